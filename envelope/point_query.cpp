#include "point_query.hpp"

#include <cmath>
#include <utility>
#include <variant>

#include "../core/numbers/exact.hpp"
#include "../core/platform.hpp"
#include "../primitives/bases/plane_base.hpp"
#include "../primitives/bases/radial_base.hpp"
#include "../primitives/charts/radial_foot.hpp"
#include "../primitives/objects/decided_scene.hpp"
#include "recursion/form_locator.hpp"

namespace vcell {

namespace {

// The forms that have sites: hidden ones may tie with what hides them, and own nothing.
template <class Sites>
std::vector<FormId> owners(const Sites& sites) {
    std::vector<FormId> owners;
    for (const FormId f : sites.ids())
        if (!sites[f].empty()) owners.push_back(f);
    return owners;
}

class OverPlane {
public:
    explicit OverPlane(PlaneBaseProblem problem)
        : problem_(std::move(problem)),
          locator_(problem_.family, owners(problem_.sites), box(problem_), false) {}
    OverPlane(const OverPlane&) = delete;

    const PlaneBaseProblem& problem() const { return problem_; }

    std::optional<PointAnswer> operator()(const Vec3& world) {
        const Vec3 p = problem_.frame.to_canonical(world / problem_.unit);
        for (const RegionSide& side : problem_.region)
            if (is_outside(side, p)) return std::nullopt;
        const FormId owner = locator_.lowest(p.x(), p.y());
        PointAnswer answer;
        answer.site = problem_.sites[owner].front();
        answer.clearance =
            problem_.unit * (problem_.family.is_circular(owner)
                                 ? problem_.family.forms[owner](p.x(), p.y())
                                 : cylinder_height(problem_.family.cylinder(owner), p.x(), p.y()));
        const Interval height = locator_.heights().value(owner, Interval(p.x()), Interval(p.y()));
        answer.inside =
            p.z() >= 0 && (p.z() <= height.lower() || (p.z() <= height.upper() && is_below(p, owner)));
        return answer;
    }

private:
    static std::array<double, 4> box(const PlaneBaseProblem& problem) {
        std::array<double, 4> box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
        for (const Eigen::Vector2d& c : problem.corners)
            box = {std::min(box[0], c.x()), std::max(box[1], c.x()), std::min(box[2], c.y()),
                   std::max(box[3], c.y())};
        return box;
    }

    static bool is_outside(const RegionSide& side, const Vec3& p) {
        const Interval x(p.x()), y(p.y());
        if (const auto s = (side.a * x + side.b * y + Interval(side.c)).sign()) return *s == Sign::Negative;
        return (side.a * Exact(p.x()) + side.b * Exact(p.y()) + Exact(side.c)).sign() == Sign::Negative;
    }

    // Pre: z >= 0.
    bool is_below(const Vec3& p, FormId owner) const {
        const Exact x = p.x(), y = p.y(), z = p.z();
        if (problem_.family.is_circular(owner)) {
            const ExactForm f = problem_.family.exact(owner);
            return (f.K * (x * x + y * y) + f.A * x + f.B * y + f.C - f.W * z).sign() != Sign::Negative;
        }
        const ExactCylinder f = exact_cylinder(problem_.family.cylinder(owner));
        const auto [C, beta] = cylinder_terms(f, f.unit * x, f.unit * y);
        const Exact t = f.unit * z;
        return (C - (beta + beta) * t - f.az * f.az * t * t).sign() != Sign::Negative;
    }

    PlaneBaseProblem problem_;
    FormLocator locator_;
};

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

class OverCurved {
public:
    explicit OverCurved(RadialBaseProblem problem)
        : problem_(std::move(problem)),
          locator_(problem_.family, owners(problem_.sites), box(problem_), problem_.is_sphere) {}
    OverCurved(const OverCurved&) = delete;

    const RadialBaseProblem& problem() const { return problem_; }

    std::optional<PointAnswer> operator()(const Vec3& world) {
        const Vec3 p = problem_.frame.to_canonical(world / problem_.unit);
        if (!problem_.is_sphere && (p.y() < problem_.stretch[0] || p.y() > problem_.stretch[1]))
            return std::nullopt;
        const Vec3 across(p.x(), RadialFoot(problem_.is_sphere).across(p.y()), p.z());
        PointAnswer answer;
        if (across.isZero(0)) {
            answer.inside = true;
            return answer;
        }
        Vec2 chart = problem_.chart_point(across.stableNormalized(), p.y());
        // Near the pole coordinates grow beyond all bounds, or are none; one object is nearest there.
        constexpr double farthest = 0x1p30;
        if (problem_.is_sphere && !(chart.norm() <= farthest))
            chart = chart.allFinite() ? Vec2(farthest * chart.stableNormalized()) : Vec2(farthest, 0);
        const FormId owner = locator_.lowest(chart.x(), chart.y());
        answer.site = problem_.sites[owner].front();
        // The point is at distance s <= W / Q, where the owner's q = Q / W is a root: q s <= 1.
        const Interval X(chart.x()), Y(chart.y()), Z(across.z());
        const Interval s = sqrt(square(Interval(across.x())) + square(Interval(across.y())) + square(Z));
        const Interval q =
            -locator_.heights().value(owner, X, Y) * locator_.heights().scale(X, Y) / weight(X, Y);
        constexpr double exact_enough = 0x1p-44;  // of the distance: output accuracy
        if (q.lower() > 0 && q.upper() - q.lower() <= exact_enough * q.lower() && !(s * q).contains(1)) {
            answer.clearance = problem_.unit * (1 / q.mid() - problem_.radius);
            answer.inside = (s * q).upper() < 1;
            return answer;
        }
        // C q^2 - 2 B q - A^2 <= 0 at q = 1 / s, where it is not beyond the larger root.
        const ExactTerms f = terms(problem_.family, owner, chart);
        answer.clearance = problem_.unit * (distance(f) - problem_.radius);
        const Exact s2 =
            Exact(across.x()) * across.x() + Exact(across.y()) * across.y() + Exact(across.z()) * across.z();
        answer.inside =
            sign(OneRoot{f.C * f.W * f.W - f.A * f.A * s2, -2.0 * f.B * f.W, s2}) != Sign::Negative;
        return answer;
    }

private:
    static std::array<double, 4> box(const RadialBaseProblem& problem) {
        // A millionth of the sphere lies farther out.
        constexpr double reach = 0x1p10;
        if (problem.is_sphere) return {-reach, reach, -reach, reach};
        return {-1, 3, problem.stretch[0], problem.stretch[1]};
    }

    // W.
    Interval weight(const Interval& x, const Interval& y) const {
        if (problem_.is_sphere) return Interval(1.0) + square(x) + square(y);
        return Interval(1.0) + square(x.mid() <= 1 ? x : x - Interval(2.0));
    }

    RadialBaseProblem problem_;
    FormLocator locator_;
};

}  // namespace

struct PointQuery::Bases {
    template <class Base, class Problem>
    Bases(std::in_place_type_t<Base> over, Problem&& problem) : base(over, std::forward<Problem>(problem)) {}

    std::variant<OverPlane, OverCurved> base;
};

PointQuery::PointQuery(const Scene& scene)
    : bases_(in_ieee_arithmetic("PointQuery", [&] {
          validate(scene);
          const DecidedScene decided = decide(scene);
          if (std::holds_alternative<Plane>(scene.base))
              return std::make_unique<Bases>(std::in_place_type<OverPlane>,
                                             plane_base_problem(decided.scene, decided.unit));
          return std::make_unique<Bases>(std::in_place_type<OverCurved>,
                                         radial_base_problem(decided.scene, decided.unit));
      })) {}

PointQuery::PointQuery(PointQuery&&) noexcept = default;
PointQuery& PointQuery::operator=(PointQuery&&) noexcept = default;
PointQuery::~PointQuery() = default;

std::optional<PointAnswer> PointQuery::operator()(const Vec3& world) {
    return std::visit([&](auto& base) { return base(world); }, bases_->base);
}

const std::vector<std::string>& PointQuery::warnings() const {
    return std::visit(
        [](const auto& base) -> const auto& { return base.problem().warnings; }, bases_->base);
}

}  // namespace vcell
