/// The objects of a scene, in world coordinates and the user's unit of length.
#pragma once

#include "../../core/platform.hpp"

#include <Eigen/Core>
#include <cmath>
#include <variant>

namespace vcell {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;

/// The plane through `point` across `normal` (need not be unit, must not be zero).
/// As a base its cell lies on the side the normal points to; as an object its distance is unsigned.
struct Plane {
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ();

    friend bool operator==(const Plane&, const Plane&) = default;
};

/// The ball's surface; radius 0 is a point.
struct Sphere {
    Vec3 center = Vec3::Zero();
    double radius = 0;

    friend bool operator==(const Sphere&, const Sphere&) = default;
};

/// The infinite cylinder about the line through `point` along `axis` (need not be unit, must not be
/// zero); radius 0 is a line.
struct Cylinder {
    Vec3 point = Vec3::Zero();
    Vec3 axis = Vec3::UnitZ();
    double radius = 0;

    friend bool operator==(const Cylinder&, const Cylinder&) = default;
};

/// A vessel: everything lies in the sphere, and the point x is R - |x - c| away from its wall, less than
/// nothing beyond it. It competes as an object and is no base.
struct HollowSphere {
    Vec3 center = Vec3::Zero();
    double radius = 1;  ///< > 0

    friend bool operator==(const HollowSphere&, const HollowSphere&) = default;
};

/// A vessel likewise: the infinite tube seen from within; `axis` need not be unit, must not be zero.
struct HollowCylinder {
    Vec3 point = Vec3::Zero();
    Vec3 axis = Vec3::UnitZ();
    double radius = 1;  ///< > 0

    friend bool operator==(const HollowCylinder&, const HollowCylinder&) = default;
};

/// A vessel likewise: the infinite cone that opens from `apex` along `axis` (need not be unit, must not be
/// zero), its rim of radius `radius` being `slant` away from the apex along the wall: radius / slant is the
/// sine of half its angle, exactly. From its wall a point is as far as from the nearest of the planes that
/// touch the wall, less than nothing beyond it.
struct HollowCone {
    Vec3 apex = Vec3::Zero();
    Vec3 axis = Vec3::UnitZ();
    double radius = 1;  ///< > 0
    double slant = 2;   ///< > radius

    /// Those of half the angle, within a few 2^-53 of themselves.
    double sine() const { return radius / slant; }
    double cosine() const {
        return std::sqrt((slant - radius) / slant) * std::sqrt((slant + radius) / slant);
    }

    friend bool operator==(const HollowCone&, const HollowCone&) = default;
};

using Object = std::variant<Plane, Sphere, Cylinder, HollowSphere, HollowCylinder, HollowCone>;

inline bool is_vessel(const Object& object) {
    return std::holds_alternative<HollowSphere>(object) || std::holds_alternative<HollowCylinder>(object) ||
           std::holds_alternative<HollowCone>(object);
}

/// Axis-parallel box in world coordinates; min < max in every coordinate.
struct Box {
    Vec3 min = Vec3::Zero();
    Vec3 max = Vec3::Zero();

    double diagonal() const { return (max - min).norm(); }
};

}  // namespace vcell
