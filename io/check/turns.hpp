/// Directions of distances all over a ball of points, in doubles with bounds: what is asked most often of
/// most sites, before intervals.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <variant>

#include "../../primitives/objects/scene.hpp"

namespace vcell::check {

/// The distance of a ball's center from an object, and the direction in which it grows, which turns by at
/// most `turn` within the ball. `rounding` bounds the error of the distance.
struct Slope {
    double distance, rounding;
    Vec3 direction;
    double turn;
};

/// Operations below round a few times each: 2^-48 of their operands is more than all of it.
inline constexpr double kRough = 0x1p-48;

/// `is_base`: of a plane the distance is signed.
inline Slope slope_within(const Object& object, const Vec3& center, double radius, bool is_base) {
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const Vec3 n = plane->normal.normalized(), q = center - plane->point;
        const double d = n.dot(q), rounding = kRough * q.cwiseAbs().sum();
        if (is_base) return {d, rounding, n, kRough};
        // Unsigned: on the plane the direction jumps.
        return {std::abs(d), rounding, d < 0 ? Vec3(-n) : n, std::abs(d) > radius + rounding ? kRough : 2.0};
    }
    Vec3 q;
    double size, own;
    const auto across = [&](const auto& tube) {
        const Vec3 d = tube.axis.normalized(), way = center - tube.point;
        q = way - d.dot(way) * d;
        size = way.norm();
        own = tube.radius;
    };
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        q = center - sphere->center;
        size = q.norm();
        own = sphere->radius;
    } else if (const auto* cylinder = std::get_if<Cylinder>(&object)) {
        across(*cylinder);
    } else if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        q = center - vessel->center;
        size = q.norm();
        own = vessel->radius;
    } else if (const auto* cone = std::get_if<HollowCone>(&object)) {
        const double sine = cone->radius / cone->slant,
                     cosine = std::sqrt((cone->slant - cone->radius) / cone->slant * (1 + sine));
        const Vec3 d = cone->axis.normalized(), way = center - cone->apex, out = way - d.dot(way) * d;
        const double length = out.norm(), rounding = kRough * way.norm();
        const double turn = length > radius ? 2 * (radius + rounding) / (2 * length - radius) : 2.0;
        return {sine * d.dot(way) - cosine * length, rounding,
                sine * d - cosine * (length > 0 ? Vec3(out / length) : Vec3(d.unitOrthogonal())),
                length > 0 ? std::min(2.0, (1 + kRough) * turn + 4 * kRough) : 2.0};
    } else {
        across(std::get<HollowCylinder>(object));
    }
    const double length = q.norm(), rounding = kRough * (size + own);
    // [For x and y of lengths a and b: |x / a - y / b| <= 2 |x - y| / (a + b), by the triangle's inequality.]
    const double turn = length > radius ? 2 * (radius + rounding) / (2 * length - radius) : 2.0;
    const double sign = is_vessel(object) ? -1 : 1;
    return {sign * (length - own), rounding, sign * (length > 0 ? Vec3(q / length) : Vec3(Vec3::UnitX())),
            length > 0 ? std::min(2.0, (1 + kRough) * turn + kRough) : 2.0};
}

}  // namespace vcell::check
