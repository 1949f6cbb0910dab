/// How far a site is at least all over a curve or a patch, by a tangent of its distance.
#pragma once

#include "nets.hpp"
#include "space.hpp"

namespace vcell::check {

/// A lower bound of a site's excess all over a net: -infinity for vessels, and where weights may vanish.
///
/// The distances from balls, tubes and planes are convex: d(p) >= d(c) + g (p - c) with the gradient g at any
/// place c. The clearance is convex, too, so that d(c) + g (p - c) less the clearance at p is concave, and
/// least at a control point, in whose hull the net lies. The bound is off by the square of the net's size at
/// most; all along what a plane has in common with a tube or a ball that it touches it is exact, however long
/// that is. c is the middle of the net, or next to it where the excess is least.
double least_by_tangents(const Space<Interval>& space, const Condition& condition, const Net& net);

}  // namespace vcell::check
