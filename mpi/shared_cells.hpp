/// Cells of balls that are only measured: each face once, by the rank that has the ball of the lower number.
#pragma once

#include <vector>

#include "scene_parts.hpp"
#include "surroundings.hpp"

namespace vcell::mpi {

/// Those of the own objects, in their order, as voronoi_diagram() has them to the last digit. Pre:
/// around.are_sharing().
std::vector<DiagramCell> shared_cells(Ranks& ranks, const SceneParts& parts, Surroundings& around,
                                      unsigned threads);

}  // namespace vcell::mpi
