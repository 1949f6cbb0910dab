// The arcs of a plain piece (mixed_piece.hpp): the labels along its boundary and the points in which three
// rivals are lowest determine them.
#pragma once

#include "piece_argument.hpp"
#include "piece_vertices.hpp"

namespace vcell {

class PlainJoin : PieceArgument {
public:
    PlainJoin(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    bool is_plain() const;
    /// Draws the piece, if all that it takes is told. Pre: is_plain().
    bool join();

private:
    // A vertex of the rim in which more forms meet than change there, and those that are lowest around it
    // inside the piece, counter-clockwise from the label of the side that leaves to that of the one that
    // arrives.
    struct RimKnot {
        std::uint32_t vertex;
        std::vector<FormId> ties, around;
    };

    std::optional<RimKnot> forms_around_knot(std::uint32_t v);
    bool leave_one_end(const std::array<FormId, 3>& forms) const;
    bool join_all(std::span<const RimKnot> knots);
    bool join_pair(const Vector2d& direction, FormId f, FormId g, std::vector<RimChange>& ends);
    std::optional<bool> shows_beside_floor(const MixedPiece::Vertex& v, const std::array<FormId, 3>& three);
};

}  // namespace vcell
