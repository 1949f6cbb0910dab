/// The height over a cylinder base in doubles, canonical, about a place along the axis, and tips of
/// bisectors: what is asked of a form's numbers where nothing is decided.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "radial_base.hpp"

namespace vcell {

/// C, B and A of primitives/forms/radial_form.hpp divided by lengths: with the axis w of a tube or a cone,
/// unit, and the sine S of half a cone's angle
///
///     C(y) = c[0] + c[1] y + c[2] y^2,   A = a.u + a0,   B = b.u + b0 + slope y A,
///
/// a = w across the base's axis, a0 = -S and slope = w_y, or -w_y in a vessel; y is counted from `start`,
/// where C is told without cancellation.
struct AxialTerms {
    std::array<double, 3> c;
    Vec3 b, a;
    double b0, a0, slope, start;
    bool has_root;

    /// Pre: over a cylinder.
    AxialTerms(const RadialBaseProblem& problem, FormId form, double start);

    /// The cosine of half a hollow cone's angle, 1 of tubes.
    double spread() const { return std::sqrt((1 - a0) * (1 + a0)); }
};

/// Where the axis of a hollow tube or cone is as far from the base as from its own wall, or that of a tube
/// that pierces the base as far within it as the tube is thick, the bisector comes to a tip: in the direction
/// u, `reach` away from the base's centre or axis; over a cylinder, over the axis's point at y, canonical.
/// There the distance along the base's normals is continuous, but has no derivative. `is_far`: as one goes on
/// along the object's own axis the base falls behind its wall: of two tips it is so in the farther one. None
/// for other objects, and tubes along the base. To some roundings. Pre: over a sphere or a cylinder.
struct BisectorTip {
    double y, reach;
    Vec3 u;
    bool is_far;

    /// Canonical.
    Vec3 point() const { return Vec3(0, y, 0) + reach * u; }
};
/// Where along an axis from q, with the direction a, both seen across the base's axis if it has one, a place
/// is as far from the base as from the wall: the roots h of |q + h a| = sine h + reach, and of the same with
/// the other sign, ascending; not finite where there is only one. None if there are no real ones.
std::optional<std::array<double, 2>> tips_along(const Vec3& q, const Vec3& a, double sine, double reach);
std::vector<BisectorTip> bisector_tips(const RadialBaseProblem& problem, FormId form);

}  // namespace vcell
