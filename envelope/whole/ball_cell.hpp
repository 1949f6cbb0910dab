/// The measures of a ball's cell among balls, without a search before it: the cell among the nearest balls
/// tells by its marks which others may touch it, and those are inserted where it is.
///
/// A face between two balls is measured once, in the cell of the one with the lower number, which gives the
/// other one its part (arc_measures.hpp): both have the same area, and their parts of the volume have no gap.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cell_finder.hpp"

namespace vcell::whole {

/// None where that is no common case: for voronoi_cell() to decide, among balls that a CellBound finds.
/// `around`: none if it is the ball's alone. Where it shares, faces with balls of lower numbers are contacts
/// without faces, and their part of the volume is not in it. Pre: the diagram is simple, the room is the
/// ball's (DecidedDiagram::room()) and holds its centre.
std::optional<FoundCell> measured_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                            const Box& room, const Neighborhood* around, bool is_sharing);

/// Gives what cells share to those that have it not. Returns the cells, ascending, that nobody gives what
/// they lack.
std::vector<std::uint32_t> share_faces(std::span<DiagramCell> cells, std::span<const SharedParts> parts);
/// Measures all faces of such a cell among its neighbours, which are known. False where that is no common
/// case.
bool complete_ball_cell(const DecidedDiagram& decided, std::uint32_t object, DiagramCell& cell);

}  // namespace vcell::whole
