/// The conics over a sphere base: edges between balls, planes and sides of the box.
///
/// Where one of these is met at the distance t from the base's centre in p, t Q = W times a positive factor
/// (primitives/forms/radial_form.hpp) is linear in the four-dimensional (p, t):
///
///     b.p + b0 t = k
///
/// Two of these hyperplanes and the cone |p| = t make a conic, as over a cylinder base (axial_conic.hpp).
#pragma once

#include <array>
#include <optional>

#include "../../core/numbers/sign.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../cell.hpp"
#include "based_diagram.hpp"
#include "conic_error.hpp"

namespace vcell::radial {

/// The equation above. `square` is b.b - b0^2.
struct Functional {
    Vec3 b;
    double b0, square, k;
};

/// A form's hyperplane, its normal of length 1.
///
/// Where a bisector runs out to infinity, a point's direction tells its distance badly, and rounding in the
/// chart moves curves off their bisectors by far more than rounding in space. So points (p, t) are moved to
/// where their hyperplanes say, by the least that does.
class Hyperplane {
public:
    Hyperplane(const RadialBaseProblem& problem, FormId f);

    const Functional& functional() const { return functional_; }
    const DistancePlane& plane() const { return plane_; }
    const Eigen::Vector4d& normal() const { return plane_.normal; }
    /// How far off a homogeneous point of that weight is.
    double residual(const Eigen::Vector4d& x, double weight) const {
        return plane_.normal.dot(x) - weight * plane_.k;
    }
    /// The weight that a point must have to lie on it.
    double weight(const Eigen::Vector4d& x) const { return plane_.normal.dot(x) / plane_.k; }
    /// The gradient of 1 / t, which is linear in the direction u.
    Vec3 gradient() const { return plane_.normal.head<3>() / plane_.k; }
    double steepness() const { return 1 / std::abs(plane_.k); }

private:
    Functional functional_;
    DistancePlane plane_;
};

/// The hyperplanes of those circular forms that a diagram names: most forms of many are hidden.
class Hyperplanes {
public:
    Hyperplanes(const RadialDiagram& of, unsigned threads);

    /// Pre: a label of the diagram has the form, which is circular.
    const Hyperplane& operator[](FormId f) const { return *planes_[f]; }

private:
    IdVector<FormId, std::optional<Hyperplane>> planes_;  // over a cylinder no form is circular
};

/// x, homogeneous of that weight, moved to the common points of both; where they are all but parallel, to
/// those of the first.
Eigen::Vector4d moved(const Eigen::Vector4d& x, double weight,
                      const std::array<const Hyperplane*, 2>& planes);
/// x, of weight 1, moved to the common points of both and to the cone |p| = t, so that a conic's control
/// point lies on its sites.
Eigen::Vector4d moved_on_cone(const Eigen::Vector4d& x, const std::array<const Hyperplane*, 2>& planes);
/// x moved to three hyperplanes and the cone: a step of Newton's method. May fail with numbers that are not
/// finite.
Eigen::Vector4d moved_to_meet(const Eigen::Vector4d& x, const std::array<const Hyperplane*, 3>& planes);

/// What two forms' equations leave on each other: a plane through 0. The difference of forms that are nearly
/// alike has all its digits.
DistancePlane difference_plane(const RadialBaseProblem& problem, FormId f, FormId g);

/// The kind of the conic on which two forms agree, decided exactly.
///
/// In homogeneous coordinates the cone |n| = W lifts to the curve by p = n / Q; the plane {Q_f = Q_g} of its
/// points meets infinity, Q_f = 0, in a line, and that line meets the cone in two points, in one, or in none
/// as the Gram determinant of (b_f, b0_f) and (b_g, b0_g) in the cone's metric is positive, zero or negative.
class SphereConicKind {
public:
    using Approximate = Functional;

    /// `decisions` counts its signs.
    SphereConicKind(const RadialBaseProblem& problem, Decisions& decisions)
        : problem_(problem), decisions_(decisions) {}

    /// p and q: the forms' functionals.
    CurveKind operator()(FormId f, FormId g, const Approximate& p, const Approximate& q);

private:
    bool are_parallel(FormId f, FormId g, const Vec3& p, const Vec3& q);
    Sign gram_sign(FormId f, FormId g, const Approximate& p, const Approximate& q);

    const RadialBaseProblem& problem_;
    Decisions& decisions_;
};

}  // namespace vcell::radial
