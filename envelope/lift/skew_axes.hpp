/// The axes of a cylinder base and of a cylinder of its radius that is skew to it, and the bisector of both.
///
/// Counted from half-way between the axes on their common perpendicular z, with x and y on the bisectors of
/// their directions d0 = (c, -s) and d = (c, s), lengths h and -h / 2 along z, the points are as far from
/// both where
///
///     (s x + c y)^2 + (z + h / 2)^2 = (s x - c y)^2 + (z - h / 2)^2,   z = -(2 s c / h) x y:
///
/// a hyperbolic paraboloid, and a graph over the plane of x and y. Where the axes are nearly in one plane the
/// graph is steep, and what is off it by e along x is off it by about e |y| 2 s c / h along z.
#pragma once

#include <optional>

#include "../../primitives/bases/radial_base.hpp"

namespace vcell {

/// Canonical. x and y are unit vectors, at right angles, counter-clockwise seen from outside the cell; z = x
/// cross y points away from the base.
struct SkewAxes {
    Vec3 x, y;
    Vec3 origin;    ///< a point of the base's axis, or moved()
    double x0, y0;  ///< of the origin: axes that are all but parallel lose digits where they are nearest
    double steep;   ///< 2 s c / h
    double apart;   ///< h, a length

    /// None where the radii differ or the axes are in one plane. The origin is at the height y. Pre: the base
    /// is a cylinder.
    static std::optional<SkewAxes> of(const RadialBaseProblem& problem, FormId form, double y);

    /// Moves the origin along x.
    SkewAxes moved(double by) const {
        SkewAxes result = *this;
        result.origin += by * x;
        result.x0 += by;
        return result;
    }
};

}  // namespace vcell
