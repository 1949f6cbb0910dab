/// vcell with files: reads scenes, computes cells and diagrams, writes them, meshes and draws them, checks
/// cells and answers about points.
///
/// Users include this header and link vcell::io, which brings vcell::vcell. What is in it has headers of its
/// own: <vcell/io/files/scene_file.hpp> and so on, listed in <vcell/io/io.hpp>.
#pragma once

#include "io/io.hpp"
#include "vcell.hpp"
