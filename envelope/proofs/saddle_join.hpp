// The arcs of small pieces in which two trisectors all but meet: two forms whose difference has a saddle, and
// three of which one is pinched off between the other two.
#pragma once

#include "piece_argument.hpp"

namespace vcell {

class SaddleJoin : PieceArgument {
public:
    SaddleJoin(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    bool join_at_saddle();
    bool join_at_pinch();
};

}  // namespace vcell
