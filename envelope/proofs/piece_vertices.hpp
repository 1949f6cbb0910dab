// The points of a piece in which three of its rivals are equal.
#pragma once

#include "piece_argument.hpp"

namespace vcell {

class PieceVertices : PieceArgument {
public:
    PieceVertices(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    /// The point inside in which the three are equal, which is known to exist. False: it is not found.
    bool locate(const std::array<FormId, 3>& three, MixedPiece::Vertex& v);
    /// Is there one in the piece?
    Inside find(const std::array<FormId, 3>& three, MixedPiece::Vertex& out);

private:
    std::array<FormId, 3> told_apart(const std::array<FormId, 3>& forms) const;
};

}  // namespace vcell
