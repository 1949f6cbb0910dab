/// What a trimming curve and its edge are compared by: spans of both, and the patch about them.
#pragma once

#include "nets.hpp"

namespace vcell::check {

/// A span of a trimming curve and the part of the edge that it follows, in its direction.
struct TrimPair {
    BezierPiece<2> trim;
    BezierPiece<3> edge;
};

/// A patch's net and the rectangle of its parameters.
struct NetOver {
    const Net* net;
    Vec2 lo, hi;

    /// From places beside the net's corner to shares of its width. A needle may be no wider than that its
    /// trimming curves have one coordinate, the corner's: then all shares are 0 in any scale.
    MidRad scale_to_shares(int axis) const {
        if (lo[axis] == hi[axis]) return 1.0;
        return MidRad(1.0) / (MidRad(hi[axis]) - lo[axis]);
    }
};

/// Relative: of n operations, one after the other.
constexpr double rounding_of(int n) { return n * 0x1p-53; }

/// Bounds |S(c(t)) - C(t)| by its values at as many places as it has coefficients, or about twice as
/// many. Infinite where the curve runs far beside the patch, degrees are none of the usual ones, or so
/// low that many places tell no more.
double gap_at_places(const NetOver& over, const TrimPair& pair, bool are_many);

}  // namespace vcell::check
