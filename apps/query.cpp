#include "query.hpp"

#include <cmath>

#include "../core/numbers/exact.hpp"
#include "../envelope/diagram/minimization_diagram.hpp"

namespace vcell {

std::optional<PointAnswer> query_point(const PlaneBaseProblem& problem, const Vec3& world) {
    const Vec3 p = problem.frame.to_canonical(world / problem.unit);
    const Exact x = p.x(), y = p.y(), z = p.z();
    for (const RegionSide& side : problem.region)
        if ((side.a * x + side.b * y + Exact(side.c)).sign() == Sign::Negative) return std::nullopt;
    const FormId owner = lowest_form(problem.family, p.x(), p.y());
    PointAnswer answer;
    answer.site = problem.sites[owner].front();
    Exact above;  // has the sign of height - z, for z >= 0
    if (problem.family.is_circular(owner)) {
        const ExactForm f = problem.family.exact(owner);
        answer.clearance = problem.unit * problem.family.forms[owner](p.x(), p.y());
        above = f.K * (x * x + y * y) + f.A * x + f.B * y + f.C - f.W * z;
    } else {
        const ExactCylinder f = exact_cylinder(problem.family.cylinder(owner));
        const auto [C, beta] = cylinder_terms(f, f.unit * x, f.unit * y);
        answer.clearance = problem.unit * cylinder_height(problem.family.cylinder(owner), p.x(), p.y());
        const Exact t = f.unit * z;
        above = C - (beta + beta) * t - f.az * f.az * t * t;
    }
    answer.inside = z.sign() != Sign::Negative && above.sign() != Sign::Negative;
    return answer;
}

namespace {

// C Q^2 - 2 B Q - A^2 = 0 at a chart point, and W.
struct ExactTerms {
    Exact A, B, C, W;
};

ExactTerms terms(const FormFamily& family, FormId f, const Vec2& p) {
    const bool stereographic = family.chart == RadialChart::Stereographic;
    const bool front = stereographic || p.x() <= 1;
    const Exact x = front ? Exact(p.x()) : Exact(p.x()) - 2.0, y = p.y();
    const Exact r2 = stereographic ? x * x + y * y : x * x, W = Exact(1.0) + r2;
    if (family.is_circular(f)) {
        const ExactForm e = family.exact(f);
        return {Exact(), -(e.K * r2 + e.A * x + e.B * y + e.C), e.W.scaled(1), W};
    }
    const RadialForm& form = family.radial_form(f);
    const Exact side = front ? 1.0 : -1.0;
    const std::array<Exact, 3> n{side * x.scaled(1), stereographic ? y.scaled(1) : Exact(),
                                 side * (Exact(1.0) - r2)};
    const auto along = [&](const std::array<Exact, 3>& v) { return v[0] * n[0] + v[1] * n[1] + v[2] * n[2]; };
    const Exact A = along(form.a), height = stereographic ? Exact() : y;
    return {A, form.b0 * W + along(form.b) + height * form.slope * A,
            form.c[0] + height * (form.c[1] + height * form.c[2]), W};
}

// W / Q, written without cancellation.
double distance(const ExactTerms& f) {
    const double A = f.A.enclosure().mid(), B = f.B.enclosure().mid(), C = f.C.enclosure().mid(),
                 W = f.W.enclosure().mid();
    const double root = std::sqrt(B * B + A * A * C);
    return B >= 0 ? C * W / (B + root) : W * (root - B) / (A * A);
}

}  // namespace

std::optional<PointAnswer> query_point(const RadialBaseProblem& problem, const Vec3& world) {
    const Vec3 p = problem.frame.to_canonical(world / problem.unit);
    if (!problem.is_sphere && (p.y() < problem.stretch[0] || p.y() > problem.stretch[1])) return std::nullopt;
    Vec3 across = p;
    if (!problem.is_sphere) across.y() = 0;
    PointAnswer answer;
    if (across.isZero(0)) {
        answer.inside = true;
        return answer;
    }
    Vec2 chart = problem.chart_point(across.stableNormalized(), p.y());
    // Near the pole coordinates grow beyond all bounds, or are none; one object is nearest there.
    constexpr double farthest = 0x1p30;
    if (problem.is_sphere && !(chart.norm() <= farthest))
        chart = chart.allFinite() ? Vec2(farthest * chart.stableNormalized()) : Vec2(farthest, 0);
    const FormId owner = lowest_form(problem.family, chart.x(), chart.y());
    const ExactTerms f = terms(problem.family, owner, chart);
    answer.site = problem.sites[owner].front();
    answer.clearance = problem.unit * (distance(f) - problem.radius);
    // The point is at distance s <= W / Q, that is Q <= W / s, where C Q^2 - 2 B Q - A^2 is not negative:
    // C W^2 - A^2 s^2 - 2 B W s >= 0.
    const Exact s2 =
        Exact(across.x()) * across.x() + Exact(across.y()) * across.y() + Exact(across.z()) * across.z();
    answer.inside = sign(OneRoot{f.C * f.W * f.W - f.A * f.A * s2, -2.0 * f.B * f.W, s2}) != Sign::Negative;
    return answer;
}

}  // namespace vcell
