/// How far a point is from an object, in doubles.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "../primitives/objects/objects.hpp"

namespace vcell {

/// The point that says where an object is: with its coordinates distances from the object are rounded.
inline const Vec3& place_of(const Object& object) {
    return std::visit(
        [](const auto& o) -> const Vec3& {
            if constexpr (requires { o.center; })
                return o.center;
            else if constexpr (requires { o.apex; })
                return o.apex;
            else
                return o.point;
        },
        object);
}
inline Vec3& place_of(Object& object) { return const_cast<Vec3&>(place_of(std::as_const(object))); }

/// Negative in a solid, and beyond the wall of a vessel. Off by a few roundings of the coordinates.
inline double distance_from(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object))
        return std::abs(plane->normal.stableNormalized().dot(p - plane->point));
    if (const auto* sphere = std::get_if<Sphere>(&object))
        return (p - sphere->center).norm() - sphere->radius;
    if (const auto* vessel = std::get_if<HollowSphere>(&object))
        return vessel->radius - (p - vessel->center).norm();
    const auto from_axis = [&](const auto& tube) {
        return (p - tube.point).cross(tube.axis.stableNormalized()).norm();
    };
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) return vessel->radius - from_axis(*vessel);
    if (const auto* cone = std::get_if<HollowCone>(&object)) {
        const Vec3 w = cone->axis.stableNormalized(), m = p - cone->apex;
        return cone->sine() * w.dot(m) - cone->cosine() * m.cross(w).norm();
    }
    const auto& tube = std::get<Cylinder>(object);
    return from_axis(tube) - tube.radius;
}

/// distance_from(), but negative behind a plane, too: half spaces are solid as balls and tubes are.
inline double signed_distance_from(const Object& object, const Vec3& p) {
    const auto* plane = std::get_if<Plane>(&object);
    if (plane == nullptr) return distance_from(object, p);
    return plane->normal.stableNormalized().dot(p - plane->point);
}

/// A lower bound of the distance between an object and a ball's surface; negative where they overlap.
inline double least_distance(const Object& object, const Sphere& ball) {
    // Beyond the rounding of a handful of products of coordinates and unit vectors.
    constexpr double rounding = 0x1p-46;
    const auto size_of = [](const auto& o) {
        if constexpr (requires { o.center; })
            return o.center.cwiseAbs().sum() + o.radius;
        else if constexpr (requires { o.apex; })
            return o.apex.cwiseAbs().sum();
        else if constexpr (requires { o.radius; })
            return o.point.cwiseAbs().sum() + o.radius;
        else
            return o.point.cwiseAbs().sum();
    };
    return distance_from(object, ball.center) - ball.radius -
           rounding * (std::visit(size_of, object) + size_of(ball));
}

}  // namespace vcell
