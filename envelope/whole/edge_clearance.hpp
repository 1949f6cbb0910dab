/// The least clearance along an edge, and the greatest one.
#pragma once

#include <array>
#include <optional>

#include "../../core/curves/bspline.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell::whole {

/// A point of an edge: known up to `error`, in any direction, and its clearance likewise.
struct EdgePoint {
    Vec3 point = Vec3::Zero();
    double clearance = 0, error = 0;
};

/// An arc of a trisector, between its ends; `middle` is a point of it somewhere between them.
struct EdgeArc {
    std::array<EdgePoint, 2> ends;
    EdgePoint middle;              ///< its clearance is not needed
    bool is_closed = false;        ///< it is all of the trisector; its ends are one point of it
    std::optional<double> length;  ///< an upper bound
};

/// Encloses the least clearance along an arc of the trisector of three balls. Where the errors do not tell
/// whether the trisector's narrowest point is on the arc, the enclosure is that of both answers. None where
/// no precision encloses that point. Pre: no two of the balls lie in each other.
std::optional<Interval> least_clearance(const std::array<Sphere, 3>& balls, const EdgeArc& arc);

/// The least and the greatest value of what varies along an arc.
struct Extremes {
    Interval least, greatest;

    /// Encloses the values along two arcs.
    friend Extremes united(const Extremes& a, const Extremes& b);
};

/// The clearance along an arc of the trisector of three objects, whose curve is known up to `error`.
///
/// Squared distances from a point or a line are quotients of polynomials along a curve, which stay between
/// the quotients of their Bernstein coefficients; spans are halved until these are as near as the error, or
/// as rounding, asks. Where the arc comes through the narrowest place of its trisector it is known better:
/// distances from convex objects are convex functions, and in a point x where a mean sum l_i grad d_i of
/// their gradients, l_i >= 0, is all but zero no point of the trisector is nearer than sum l_i d_i(x) to the
/// three, but for that little times its distance from x.
///
/// Pre: the first object is a ball, a tube or a plane.
Extremes clearance_along(const std::array<const Object*, 3>& objects, const RationalCurve3& curve,
                         double error);

/// direction . (p - origin) along an arc whose curve is known up to `error`. Pre: the direction is a unit
/// one.
Extremes height_along(const Vec3& origin, const Vec3& direction, const RationalCurve3& curve, double error);

}  // namespace vcell::whole
