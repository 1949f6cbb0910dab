/// The measures of a ball's cell among balls, without a search before it: the cell among the nearest balls
/// tells by its marks which others may touch it, and those are inserted where it is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "../cell.hpp"
#include "cell_finder.hpp"

namespace vcell::whole {

struct MeasuredBallCell {
    /// As measure_without_curves() has it, in the scene's unit. Its sites are places in `candidates`.
    Cell cell;
    std::vector<ImageTree::Found> candidates;
};

/// None where that is no common case: for voronoi_cell() to decide, among balls that a CellBound finds. Pre:
/// all objects of the diagram are balls, the room is the ball's (DecidedDiagram::room()) and holds its
/// centre, and there is no probe. Throws as voronoi_cell().
std::optional<MeasuredBallCell> measured_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                                   const Box& room);

}  // namespace vcell::whole
