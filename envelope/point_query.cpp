#include "point_query.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "../core/numbers/exact.hpp"
#include "../core/platform.hpp"
#include "../primitives/bases/cylinder_base.hpp"
#include "../primitives/bases/plane_base.hpp"
#include "../primitives/bases/radial_base.hpp"
#include "../primitives/forms/exact_heights.hpp"
#include "../primitives/objects/decided_scene.hpp"
#include "axis_parts.hpp"
#include "recursion/form_locator.hpp"

namespace vcell {

namespace {

// The forms that have sites: hidden ones may tie with what hides them, and own nothing.
// A floor owns no point.
template <class Problem>
std::vector<FormId> owners(const Problem& problem) {
    std::vector<FormId> owners;
    for (const FormId f : problem.sites.ids())
        if (!problem.sites[f].empty() && std::ranges::find(problem.floor, f) == problem.floor.end())
            owners.push_back(f);
    return owners;
}

// A problem, and whose its points are.
template <class Problem>
class Located {
public:
    explicit Located(Problem problem)
        : problem_(std::move(problem)), locator_(problem_.family, owners(problem_), problem_.chart_box()) {}
    Located(const Located&) = delete;

protected:
    Problem problem_;
    FormLocator locator_;
};

class OverPlane : Located<PlaneBaseProblem> {
public:
    using Located::Located;

    std::optional<PointAnswer> operator()(const Vec3& world) {
        const Vec3 p = problem_.frame.to_canonical(world / problem_.unit);
        for (const RegionSide& side : problem_.region)
            if (is_outside(side, p)) return std::nullopt;
        const FormId owner = locator_.lowest(p.x(), p.y());
        // Beyond a vessel's wall there is no base.
        if (problem_.has_curved_rim && !is_below({p.x(), p.y(), 0}, owner)) return std::nullopt;
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
    static bool is_outside(const RegionSide& side, const Vec3& p) {
        const Interval x(p.x()), y(p.y());
        if (const auto s = (side.a * x + side.b * y + Interval(side.c)).sign()) return *s == Sign::Negative;
        return (side.a * Exact(p.x()) + side.b * Exact(p.y()) + Exact(side.c)).sign() == Sign::Negative;
    }

    // Pre: z >= 0.
    bool is_below(const Vec3& p, FormId owner) const {
        const Exact z = p.z();
        const HeightEquation f = height_equation(problem_.family, owner, {p.x(), p.y()});
        const Sign excess = (f.c - (f.b + f.b) * z - f.a * z * z).sign();
        if (problem_.family.is_circular(owner) || !problem_.family.cylinder(owner).is_hollow())
            return excess != Sign::Negative;
        // Below the smaller root of what is hollow, and not beyond the other one.
        return excess != Sign::Positive && (f.b + f.a * z).sign() != Sign::Positive;
    }
};

// -r of the equation's root r < 0, written without cancellation.
double nearness(const HeightEquation& f) {
    const double c = f.c.enclosure().mid(), b = f.b.enclosure().mid(), a = f.a.enclosure().mid();
    const double root = std::sqrt(b * b + a * c);
    return b <= 0 ? (root - b) / -a : c / -(root + b);
}

class OverCurved : Located<RadialBaseProblem> {
public:
    using Located::Located;

    std::optional<PointAnswer> operator()(const Vec3& world) {
        const Vec3 p = problem_.frame.to_canonical(world / problem_.unit);
        if (p.y() < problem_.stretch[0] || p.y() > problem_.stretch[1]) return std::nullopt;
        const Vec3 across = p - problem_.chart.foot_below(p);
        PointAnswer answer;
        if (across.isZero(0)) {
            answer.inside = true;
            return answer;
        }
        Vec2 chart = problem_.chart.chart_point(across.stableNormalized(), p.y());
        // Near a sphere's pole coordinates grow beyond all bounds, or are none; one object is nearest there.
        constexpr double farthest = 0x1p30;
        if (!(chart.norm() <= farthest))
            chart = chart.allFinite() ? Vec2(farthest * chart.stableNormalized()) : Vec2(farthest, 0);
        const bool is_back = problem_.chart.is_back(chart.x());
        const FormId owner = locator_.lowest(chart.x(), chart.y());
        answer.site = problem_.sites[owner].front();
        // The point is at distance s <= W / Q, where the owner's q = Q / W is a root: q s <= 1.
        const Interval X(chart.x()), Y(chart.y()), Z(across.z());
        const Interval s = sqrt(square(Interval(across.x())) + square(Interval(across.y())) + square(Z));
        const Interval q = -locator_.heights().value(owner, X, Y) * locator_.heights().scale(X, Y) /
                           problem_.chart.weight(X, Y, is_back);
        constexpr double exact_enough = 0x1p-44;  // of the distance: output accuracy
        if (q.lower() > 0 && q.upper() - q.lower() <= exact_enough * q.lower() && !(s * q).contains(1)) {
            answer.clearance = problem_.unit * (1 / q.mid() - problem_.chart.radius);
            answer.inside = (s * q).upper() < 1;
            return answer;
        }
        // The owner's equation at -W / s, where it is not beyond the root.
        const HeightEquation f = height_equation(problem_.family, owner, {chart.x(), chart.y()});
        const Exact W = problem_.chart.weight(Exact(chart.x()), Exact(chart.y()), is_back);
        answer.clearance = problem_.unit * (W.enclosure().mid() / nearness(f) - problem_.chart.radius);
        const Exact s2 =
            Exact(across.x()) * across.x() + Exact(across.y()) * across.y() + Exact(across.z()) * across.z();
        answer.inside = sign(OneRoot{f.c * s2 - f.a * W * W, 2.0 * f.b * W, s2}) != Sign::Negative;
        // In a hollow cylinder there is another root behind.
        if (f.c.sign() == Sign::Positive && sign(OneRoot{-(f.a * W), f.b, s2}) == Sign::Negative)
            answer.inside = false;
        return answer;
    }
};

// The axis of a tube that others hold or cross somewhere comes in parts.
std::optional<AxisParts> axis_in_parts(const Scene& scene) {
    const std::optional<Cylinder> base = base_tube(scene);
    if (!base) return std::nullopt;
    AxisParts axis(scene, *base, scene.box, cylinder_frame(scene, *base));
    if (!axis.are_any_held() && !axis.are_any_crossed()) return std::nullopt;
    return axis;
}

}  // namespace

struct PointQuery::Bases {
    template <class Base, class Problem>
    void add(Problem problem) {
        for (const std::string& warning : problem.warnings)
            if (std::ranges::find(warnings, warning) == warnings.end()) warnings.push_back(warning);
        bases.push_back(std::make_unique<std::variant<OverPlane, OverCurved>>(std::in_place_type<Base>,
                                                                              std::move(problem)));
    }
    // What of a tube's stretch others hold or cross is in no part.
    void add_parts(const DecidedScene& decided, const AxisParts& axis) {
        const Scene& scene = decided.scene;
        const auto& base = std::get<Cylinder>(scene.base);
        const auto [low, high] = cylinder_base_problem(base_alone(scene), base, decided.unit).stretch;
        for (const std::array<double, 2>& whole : axis.parts()) {
            const std::array<double, 2> part{std::max(whole[0], low), std::min(whole[1], high)};
            if (!(part[0] < part[1])) continue;
            axis.on_clear_stretch(whole, [&](const auto&, const std::array<double, 2>& clear) {
                const std::array<double, 2> stretch{std::max(clear[0], low), std::min(clear[1], high)};
                const CylinderPart on_base{scene.box, stretch, {}};
                add<OverCurved>(cylinder_base_problem(scene, base, decided.unit, &on_base));
            });
        }
    }

    std::vector<std::string> warnings;
    std::vector<std::unique_ptr<std::variant<OverPlane, OverCurved>>> bases;
    std::optional<Site> cap = std::nullopt;  // as an object
};

PointQuery::PointQuery(const Scene& scene)
    : bases_(in_ieee_arithmetic("PointQuery", [&] {
          validate(scene);
          const DecidedScene decided = decide(scene);
          auto bases = std::make_unique<Bases>();
          if (std::holds_alternative<Plane>(scene.base))
              bases->add<OverPlane>(plane_base_problem(decided.scene, decided.unit));
          else if (const auto axis = axis_in_parts(decided.scene))
              bases->add_parts(decided, *axis);
          else
              bases->add<OverCurved>(radial_base_problem(decided.scene, decided.unit));
          if (scene.probe) bases->cap = decided.cap();
          return bases;
      })) {}

PointQuery::PointQuery(PointQuery&&) noexcept = default;
PointQuery& PointQuery::operator=(PointQuery&&) noexcept = default;
PointQuery::~PointQuery() = default;

std::optional<PointAnswer> PointQuery::operator()(const Vec3& world) {
    std::optional<PointAnswer> answer;
    for (const auto& base : bases_->bases) {
        answer = std::visit([&](auto& over) { return over(world); }, *base);
        if (answer) break;
    }
    if (answer && bases_->cap && answer->site == *bases_->cap) answer->site = Site::cap();
    return answer;
}

const std::vector<std::string>& PointQuery::warnings() const { return bases_->warnings; }

}  // namespace vcell
