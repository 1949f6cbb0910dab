/// In which direction the distance from an object grows.
#pragma once

#include "../object_distance.hpp"

namespace vcell::whole {

struct DistanceGradient {
    Vec3 direction;  ///< of a unit length; of a plane away from it, on either side
    /// The distance from the centre or the axis about which the direction turns, infinite for a plane: the
    /// second derivatives of the distance are no larger than its inverse.
    double arm = infinity;
};

/// In doubles, off by a few roundings of coordinates over the arm. Pre: the point is not on an axis, nor in a
/// centre.
inline DistanceGradient distance_gradient(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const Vec3 n = plane->normal.stableNormalized();
        return {n.dot(p - plane->point) < 0 ? Vec3(-n) : n};
    }
    const auto from_centre = [](const Vec3& arm) { return DistanceGradient{arm.normalized(), arm.norm()}; };
    const Vec3 m = p - place_of(object);
    const auto from_axis = [&](const Vec3& axis) {
        const Vec3 a = axis.stableNormalized();
        return from_centre(m - a.dot(m) * a);
    };
    const auto inward = [](DistanceGradient g) { return DistanceGradient{-g.direction, g.arm}; };
    if (std::holds_alternative<Sphere>(object)) return from_centre(m);
    if (const auto* tube = std::get_if<Cylinder>(&object)) return from_axis(tube->axis);
    if (std::holds_alternative<HollowSphere>(object)) return inward(from_centre(m));
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) return inward(from_axis(vessel->axis));
    const auto& cone = std::get<HollowCone>(object);
    const DistanceGradient out = from_axis(cone.axis);
    return {cone.sine() * cone.axis.stableNormalized() - cone.cosine() * out.direction, out.arm};
}

}  // namespace vcell::whole
