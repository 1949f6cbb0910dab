/// Coordinates of bisectors' patches as functions in space.
#pragma once

#include <Eigen/Core>
#include <array>

#include "../../primitives/objects/objects.hpp"

namespace vcell {

/// A coordinate of a bisector's patch as a function of the bisector's points: the quotient of two linear
/// functions of (x, y, z, t, 1), canonical. The divisor is positive over the patch.
struct PatchCoordinate {
    using Linear = Eigen::Matrix<double, 5, 1>;

    Linear numerator = Linear::Zero(), divisor = Linear::Unit(4);

    /// direction . (p - origin)
    static PatchCoordinate linear(const Vec3& direction, const Vec3& origin);
    /// The tangent of half the angle from `zero` towards `quarter` (orthonormal): at a distance t + delta
    /// from the axis through `point` across both, it is (p - point) . quarter / (t + delta + (p - point) .
    /// zero). Likewise for the stereographic coordinates of a direction from `point` about `zero`, each with
    /// its own `quarter`.
    static PatchCoordinate half_angle(const Vec3& point, const Vec3& zero, const Vec3& quarter, double delta);
    /// half_angle() in a vessel: a tube, whose points are reach - t away from the axis, or a cone about the
    /// unit vector `axis` from `point` on, its apex. With S and K the sine and cosine of half its angle
    /// points are (S h + reach - t) / K away from its axis, h from the apex along it.
    static PatchCoordinate hollow_half_angle(const Vec3& point, const Vec3& zero, const Vec3& quarter,
                                             double reach, const Vec3& axis = Vec3::Zero(), double sine = 0,
                                             double cosine = 1);
    /// The length (h - S r) / K along such a cone's wall.
    static PatchCoordinate along_cone(const HollowCone& cone, const Vec3& axis, double radius);

    double operator()(const Eigen::Vector4d& X) const {
        return value(numerator, X, 1) / value(divisor, X, 1);
    }
    /// A linear function of a point X, given times its weight: its value times the weight.
    static double value(const Linear& f, const Eigen::Vector4d& X, double weight) {
        return f.head<4>().dot(X) + weight * f[4];
    }
};

/// (u, v). Together they are one-to-one on the bisector where both divisors are positive.
using PatchCoordinates = std::array<PatchCoordinate, 2>;

}  // namespace vcell
