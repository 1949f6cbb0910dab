/// Scenes and cells as files.
#pragma once

#include "cell_file.hpp"
#include "check/check.hpp"
#include "files.hpp"
#include "mesh.hpp"
#include "obj.hpp"
#include "scene_file.hpp"
#include "svg.hpp"
