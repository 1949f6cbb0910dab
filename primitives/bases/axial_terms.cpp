#include "axial_terms.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <variant>

#include "../objects/exact_space.hpp"

namespace vcell {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

}  // namespace

AxialTerms::AxialTerms(const RadialBaseProblem& problem, FormId form, double at) : start(at) {
    const RadialForm& f = problem.family.radial_form(form);
    has_root = f.has_root();
    const Exact y(at), along_axis = y * f.slope;
    // Exact about the new start. What y adds to B is a multiple of A, which has a constant part in a cone.
    const std::array<Exact, 3> terms{f.c[0] + y * (f.c[1] + y * f.c[2]), f.c[1] + 2.0 * y * f.c[2], f.c[2]};
    Vec3 turned_b, turned_a;
    for (int i = 0; i < 3; ++i) {
        turned_b[i] = nearest(f.b[i] + along_axis * f.a[i]);
        turned_a[i] = nearest(f.a[i]);
    }
    // The axis in the equation's unit; of what has no root, the normal and what it is added to.
    const double slope_there = nearest(f.slope),
                 unit = has_root ? std::hypot(turned_a.norm(), slope_there)
                                 : std::sqrt(std::hypot(turned_b.norm(), nearest(f.b0)));
    const double squared = unit * unit;
    for (int i = 0; i < 3; ++i) c[i] = nearest(terms[i]) / squared;
    b = problem.chart.turn * turned_b / squared;
    b0 = nearest(f.b0 + along_axis * f.a0) / squared;
    a = problem.chart.turn * turned_a / unit;
    a0 = nearest(f.a0) / unit;
    slope = has_root ? slope_there / unit : 0;
}

// (|a|^2 - S^2) h^2 + 2 (q.a - S reach) h + |q|^2 - reach^2 = 0.
std::optional<std::array<double, 2>> tips_along(const Vec3& q, const Vec3& a, double sine, double reach) {
    const double squared = (a.norm() - sine) * (a.norm() + sine), half = q.dot(a) - sine * reach,
                 rest = (q.norm() - reach) * (q.norm() + reach), discriminant = half * half - squared * rest;
    if (!(discriminant >= 0) || (squared == 0 && half == 0)) return std::nullopt;
    // Without cancellation.
    const double sum = half < 0 ? half - std::sqrt(discriminant) : half + std::sqrt(discriminant);
    std::array<double, 2> both{squared != 0 ? -sum / squared : never, sum != 0 ? -rest / sum : never};
    if (both[1] < both[0]) std::swap(both[0], both[1]);
    return both;
}

// A point of the vessel's axis h from its point or apex is q + h a away from the base's centre, or across its
// axis, and is to be S h + R0 + R away, R = 0 in a cone. A tube's point may be any of its axis, and is the
// one nearest to the canonical origin.
std::vector<BisectorTip> bisector_tips(const RadialBaseProblem& problem, FormId form) {
    const Object& object = problem.objects[form];
    Vec3 point, axis;
    double sine = 0, reach = problem.chart.radius;
    if (const auto* tube = std::get_if<HollowCylinder>(&object)) {
        axis = tube->axis.stableNormalized();
        point = tube->point - axis.dot(tube->point) * axis;
        reach += tube->radius;
    } else if (const auto* thin = std::get_if<Cylinder>(&object); thin != nullptr && thin->radius < reach) {
        axis = thin->axis.stableNormalized();
        point = thin->point - axis.dot(thin->point) * axis;
        reach -= thin->radius;
    } else if (const auto* cone = std::get_if<HollowCone>(&object)) {
        point = cone->apex;
        axis = cone->axis.stableNormalized();
        sine = cone->sine();
    } else {
        return {};
    }
    const double along = problem.chart.is_cylinder() ? 0 : 1;
    const Vec3 q(point.x(), along * point.y(), point.z()), a(axis.x(), along * axis.y(), axis.z());
    const auto both = tips_along(q, a, sine, reach);
    if (!both) return {};
    std::vector<BisectorTip> tips;
    for (const double h : *both) {
        const double far = sine * h + reach;
        const Vec3 out = q + h * a;
        // A cone's may be behind its apex, from which a wall is no farther than it is less than nothing away.
        if (std::isfinite(far) && far > 0 && out.norm() > 0)
            tips.push_back({(1 - along) * (point.y() + h * axis.y()), far, out.normalized(),
                            a.dot(out) > sine * out.norm()});
    }
    return tips;
}

}  // namespace vcell
