/// How short the gradient of an object's excess may be where the excess is small.
#pragma once

#include "nets.hpp"
#include "space.hpp"

namespace vcell::check {

/// A lower bound of its length at the points within `margin` of a net's where the excess is at most `size`; 0
/// where nothing is known. Far from two bodies that all but touch, or from a small one, gradients of
/// distances are nearly the same, and boxes of their directions tell less than this, which looks at none.
///
/// From a centre, or a point of an axis beside p, the way to p has the length s for one body and s + c for
/// the other, c being what the radii and the excess make of it, and these points are w apart. The square of
/// the difference of the unit vectors is
///
///     (|w|^2 - c^2) / (s (s + c)).
///
/// Between two axes w is linear in p, and lies among those at the net's control points: a box of a leaning
/// net has points far off the bisector, where w may vanish.
///
/// Beside a plane, over which that point is at the height h and the axis rises by r per length, p being x
/// along the axis, it is 2 (h + rho + e + x r) / s with the radius rho and the excess e.
///
/// In a hollow tube or cone distances from the wall grow by the sine of half the angle along the axis,
/// wherever the nearest point of the wall is, and so on the axis, too: what differs from how much the base's
/// do counts.
double least_slope(const Space<Interval>& space, std::uint32_t object, const Net& net, double margin,
                   double size);

}  // namespace vcell::check
