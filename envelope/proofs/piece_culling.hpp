// Which forms that compete in a piece show nowhere in it, as its rim, second derivatives and many digits
// tell.
#pragma once

#include "piece_argument.hpp"

namespace vcell {

class PieceCulling : PieceArgument {
public:
    PieceCulling(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    /// Leaves out what Taylor's formula about the middle tells to be lowest nowhere. Pre: all are bent.
    void by_curvature();
    void from_rim();
    /// Leaves out what values of 320 bits tell to be lowest nowhere.
    void sharply();

private:
    bool stays_above(const Spread& g, const Spread& f) const;
};

}  // namespace vcell
