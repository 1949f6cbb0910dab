/// What the coefficients of a RadialPatch are made of.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "../../primitives/objects/objects.hpp"

namespace vcell::radial_patch_terms {

using Eigen::Vector4d;
using Polynomial = std::array<double, 3>;  // ascending powers

inline constexpr Polynomial one{1, 0, 0}, linear{0, 1, 0};
inline constexpr Polynomial angle_weight{1, 0, 1}, angle_cos{1, 0, -1}, angle_sin{0, 2, 0};

inline Vector4d vector(const Vec3& p) { return {p.x(), p.y(), p.z(), 0}; }
inline const Vector4d weight(0, 0, 0, 1);

inline Vec3 across_y(const Vec3& p) { return {p.x(), 0, p.z()}; }

// A unit vector across the unit vector `axis`, as near to `towards` as can be.
inline Vec3 across(const Vec3& axis, const Vec3& towards) {
    Vec3 x = towards - axis * axis.dot(towards);
    // Output accuracy: of a smaller sine rounding would be more than 2^-32, and any direction is as near.
    constexpr double least_sine = 0x1p-20;
    if (!(x.norm() > least_sine * towards.norm())) return axis.unitOrthogonal();
    // What rounding left of the axis counts as much more as this is shorter: on a needle along it.
    x.normalize();
    return (x - axis * axis.dot(x)).normalized();
}

}  // namespace vcell::radial_patch_terms
