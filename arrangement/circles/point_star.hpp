/// The branches of curves that leave a point of a kernel, and the sectors between them.
///
/// A branch is named by its curve, directed away from the point: the form on its left is the pair's first.
#pragma once

#include "circle_kernel.hpp"

namespace vcell {

class PointStar {
public:
    /// All curves asked about pass through the point.
    PointStar(CircleKernel& kernel, PointId point) : kernel_(kernel), point_(point) {}

    /// Does branch `x` lie strictly inside the counter-clockwise sector from `from` to `to`? (from == to: the
    /// whole turn.)
    bool branch_in_sector(FormPair from, FormPair x, FormPair to);
    /// Does the sector from `from` counter-clockwise to `to` contain the direction to the left? Pre: the
    /// point is the leftmost of all there is, so that no branch goes left.
    bool sector_contains_left(FormPair from, FormPair to);
    /// Do c and d, two directions of one curve, agree?
    bool same_direction(FormPair c, FormPair d) { return along_sign(c, d) == Sign::Positive; }
    /// Where c and d have parallel gradients: the sign of d's f - g along c near the point, on both sides
    /// alike. Zero: the same curve.
    Sign sign_beside_touching(FormPair c, FormPair d) { return curvature_order(d, c); }

private:
    int sector_of(FormPair from, FormPair x);
    Sign along_sign(FormPair c, FormPair d);
    Sign curvature_order(FormPair c, FormPair d);

    CircleKernel& kernel_;
    PointId point_;
};

}  // namespace vcell
