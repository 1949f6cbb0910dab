/// Scenes and cells as files.
#pragma once

#include "files/cell_file.hpp"
#include "check/check.hpp"
#include "files/files.hpp"
#include "pictures/mesh.hpp"
#include "pictures/obj.hpp"
#include "files/scene_file.hpp"
#include "pictures/svg.hpp"
