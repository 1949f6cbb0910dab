/// Scenes, cells and diagrams as files, meshes and pictures, and the check of cells.
#pragma once

#include "check/check.hpp"
#include "files/cell_file.hpp"
#include "files/cell_tables.hpp"
#include "files/diagram_file.hpp"
#include "files/files.hpp"
#include "files/itd_file.hpp"
#include "files/network_file.hpp"
#include "files/scene_file.hpp"
#include "files/step_file.hpp"
#include "files/stored_diagram.hpp"
#include "pictures/diagram_pictures.hpp"
#include "pictures/mesh.hpp"
#include "pictures/mesh_formats.hpp"
#include "pictures/obj.hpp"
#include "pictures/page.hpp"
#include "pictures/svg.hpp"
