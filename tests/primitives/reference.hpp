/// Reference values in doubles and in 100 digits.
#pragma once

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <variant>

#include "../../core/numbers/exact.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell {

using Real = boost::multiprecision::cpp_bin_float_100;

/// The number, to the last digit as long as its doubles span no more than that.
inline Real real(const Exact& v) {
    Real sum = 0;
    for (Exact rest = v; rest.sign() != Sign::Zero;) {
        const double part = rest.enclosure().mid();
        sum += part;
        rest -= part;
    }
    return sum;
}

/// Signed for balls and cylinders (negative inside) and for vessels (negative beyond the wall), unsigned for
/// planes.
inline double distance(const Object& object, const Vec3& p) {
    if (const auto* s = std::get_if<Sphere>(&object)) return (p - s->center).norm() - s->radius;
    if (const auto* c = std::get_if<Cylinder>(&object))
        return (p - c->point).cross(c->axis).norm() / c->axis.norm() - c->radius;
    if (const auto* s = std::get_if<HollowSphere>(&object)) return s->radius - (p - s->center).norm();
    if (const auto* c = std::get_if<HollowCylinder>(&object))
        return c->radius - (p - c->point).cross(c->axis).norm() / c->axis.norm();
    if (const auto* c = std::get_if<HollowCone>(&object)) {
        const Vec3 axis = c->axis.normalized(), m = p - c->apex;
        return c->sine() * axis.dot(m) - c->cosine() * axis.cross(m).norm();
    }
    const auto& plane = std::get<Plane>(object);
    return std::abs(plane.normal.normalized().dot(p - plane.point));
}

}  // namespace vcell
