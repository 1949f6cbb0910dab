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
#include "cell_marks.hpp"

namespace vcell::whole {

/// What a cell's search asks all balls for, of a process that knows a part of them: those whose surfaces are
/// farther than `from` from its ball's centre, and no farther than `to`.
struct BallSearch {
    double from, to;
    std::optional<PlacedMarks> marks;  ///< none: also what does not touch the cell
};

/// None where that is no common case: for voronoi_cell() to decide, among balls that a CellBound finds.
/// `around`: none if it is the ball's alone. Where it shares, faces with balls of lower numbers are contacts
/// without faces, and their part of the volume is not in it. The same comes out to the last bit whatever the
/// neighbourhood and whatever else the diagram holds than the 20 nearest balls and what the `searches`, which
/// are appended, would find. Pre: the diagram is simple, the room is the ball's (DecidedDiagram::room()) and
/// holds its centre.
std::optional<FoundCell> measured_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                            const Box& room, const Neighborhood* around, bool is_sharing,
                                            std::vector<BallSearch>* searches = nullptr);

/// The cell of find_sharing_cell(), if it is measured_ball_cell()'s. Throws nothing that is about this cell
/// alone. Pre: the object is a ball.
std::optional<FoundCell> common_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                          std::vector<BallSearch>& searches);

/// A face between two cells that share, as the one of the lower number has it.
struct GivenFace {
    std::uint32_t giver;
    CellContact contact;  ///< the giver's, with the taker
    SharedParts::Part part;
};
/// Appends what a cell gives, by ascending takers and images.
void add_given_faces(std::uint32_t giver, const DiagramCell& cell, const SharedParts& shared,
                     std::vector<GivenFace>& faces);
/// The taker is a cell that shares. Sums have the same digits where its faces come by ascending givers, as
/// those append them.
void take(const GivenFace& given, DiagramCell& cell);
/// Does a cell that shares still miss a face?
bool lacks_faces(const DiagramCell& cell);
/// All cells give and take. Returns those, ascending, that nobody gives what they lack.
std::vector<std::uint32_t> share_faces(std::span<DiagramCell> cells, std::span<const SharedParts> parts);
/// Measures all faces of such a cell among its neighbours, which are known. False where that is no common
/// case.
bool complete_ball_cell(const DecidedDiagram& decided, std::uint32_t object, DiagramCell& cell);

}  // namespace vcell::whole
