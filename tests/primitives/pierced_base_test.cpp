// Tubes that pierce a ball or a thicker tube: their heights, tips, and what boxes of the chart tell next to
// them.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "../../primitives/bases/axial_terms.hpp"
#include "../../primitives/forms/exact_heights.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"
#include "radial_base_checks.hpp"

namespace vcell::radial_base {
namespace {

// A thin tube through a ball or tube about (1, 2, 3), with an axis nearer to the base's centre or axis than
// radii differ, but not along a base tube.
RadialBaseProblem pierced(Random& r, bool is_ball, double scale) {
    const Vec3 middle(1, 2, 3);
    const double radius = scale, thin = scale * r.pick({0, 0.25, 0.5});
    const Vec3 along = r.direction();
    Vec3 axis;
    do axis = r.direction();
    while (axis.cross(along).norm() < 0.3);
    const Vec3 aside = is_ball ? Vec3(axis.unitOrthogonal()) : along.cross(axis).normalized().eval();
    const Cylinder tube{middle + 0.9 * r.unit() * (radius - thin) * aside + r.unit() * scale * axis, axis,
                        thin};
    const Object base = is_ball ? Object(Sphere{middle, radius}) : Object(Cylinder{middle, along, radius});
    return problem_of(scene_of(base, {tube}, 5 * scale));
}

FormId tube_of(const RadialBaseProblem& problem) {
    const FormId form = form_of(problem, Site::object(0));
    REQUIRE(pierces_base(problem, form));
    return form;
}

}  // namespace

TEST_CASE("pierced bases: heights are where base and tube are equally far, on both sides of C = 0") {
    Random r;
    int beyond = 0, within = 0;
    for (int round = 0; round < long_rounds(120); ++round) {
        const double scale = r.pick({1e-3, 1, 1e3});
        const bool is_ball = round % 2 == 0;
        const RadialBaseProblem problem = pierced(r, is_ball, scale);
        const FormId form = tube_of(problem);
        for (int k = 0; k < 8; ++k) {
            const double y = is_ball ? 0 : 2 * scale * r.unit();
            const Vec2 p = is_ball ? problem.chart.chart_point(r.direction(), 0) : Vec2(1 + 2 * r.unit(), y);
            if (!is_ball && (y < problem.stretch[0] || y > problem.stretch[1])) continue;
            const std::array<Exact, 3>& c = problem.family.radial_form(form).c;
            ++((c[0] + p.y() * (c[1] + p.y() * c[2])).sign() == Sign::Positive ? beyond : within);
            check_height(real(problem.chart.foot(p)), real(problem.chart.normal(p)), problem.chart.radius,
                         problem.objects[form], nearness(problem.family, form, p), scale, 1e-11);
        }
    }
    CHECK(beyond > 0);
    CHECK(within > 0);
}

TEST_CASE("pierced bases: tips lie on the tube's axis, as far from the base as from that") {
    Random r;
    for (int round = 0; round < long_rounds(60); ++round) {
        const RadialBaseProblem problem = pierced(r, round % 2 == 0, 1);
        const FormId form = tube_of(problem);
        const auto& tube = std::get<Cylinder>(problem.objects[form]);
        const std::vector<BisectorTip> tips = bisector_tips(problem, form);
        REQUIRE(tips.size() == 2);
        for (const BisectorTip& tip : tips) {
            CHECK(tip.reach == doctest::Approx(problem.chart.radius - tube.radius).epsilon(1e-14));
            CHECK(problem.chart.distance(tip.point()) == doctest::Approx(tip.reach).epsilon(1e-13));
            CHECK(tube.axis.normalized().cross(tip.point() - tube.point).norm() < 1e-13);
        }
        CHECK((tips[1].point() - tips[0].point()).dot(tube.axis) > 0);
    }
}

// Values, and differences of values against first derivatives, over boxes of all sizes, also around tips.
TEST_CASE("pierced bases: over boxes of the chart heights and slopes are enclosed, next to tips too") {
    Random r;
    for (int round = 0; round < long_rounds(30); ++round) {
        const bool is_ball = round % 2 == 0;
        const RadialBaseProblem problem = pierced(r, is_ball, 1);
        const FormId form = tube_of(problem);
        const Heights heights(problem.family);
        const std::vector<BisectorTip> tips = bisector_tips(problem, form);
        for (int k = 0; k < 60; ++k) {
            const BisectorTip& tip = tips[k % 2];
            const double width = std::exp2(-2 - 3 * (k % 5)), off = k % 3 == 0 ? 0.5 * width : 4 * width;
            const Vec2 corner = problem.chart.chart_point(tip.u, tip.y) - off * Vec2(r.unit(), r.unit());
            if (!corner.allFinite()) continue;  // at the pole
            if (!is_ball && (corner.x() < -1 || corner.x() + width > 3)) continue;
            const Interval x(corner.x(), corner.x() + width), y(corner.y(), corner.y() + width);
            const HeightJet<Interval> jet = heights.jet(form, x, y);
            const auto point = [&] {
                return Vec2(x.lower() + (0.5 + 0.5 * r.unit()) * width,
                            y.lower() + (0.5 + 0.5 * r.unit()) * width);
            };
            const auto value = [&](const Vec2& p) {
                return heights.value(form, Interval(p.x()), Interval(p.y()));
            };
            const Vec2 p = point(), q = point();
            const Interval at_p = value(p), at_q = value(q);
            CHECK(at_p.upper() >= jet.v.lower());
            CHECK(at_p.lower() <= jet.v.upper());
            const Interval by_slopes =
                at_p + jet.gx * (Interval(q.x()) - p.x()) + jet.gy * (Interval(q.y()) - p.y());
            CHECK(at_q.upper() >= by_slopes.lower());
            CHECK(at_q.lower() <= by_slopes.upper());
        }
    }
}

// What B^2 + A^2 C alone tells of the root takes boxes as small as the square of their distance from the tip,
// and so do slopes of terms that grow towards it.
TEST_CASE("pierced bases: next to tips slopes are as sharp in boxes of the same part of their distance") {
    Random r;
    for (int round = 0; round < long_rounds(30); ++round) {
        const bool is_ball = round % 2 == 0;
        const RadialBaseProblem problem = pierced(r, is_ball, 1);
        const FormId form = tube_of(problem);
        const Heights heights(problem.family);
        for (const BisectorTip& tip : bisector_tips(problem, form)) {
            const Vec2 at = problem.chart.chart_point(tip.u, tip.y);
            if (!at.allFinite() || at.norm() > 8) continue;  // towards the pole distances grow
            const double angle = 4 * r.unit();
            const auto blur = [&](double off) {
                const double width = off / 64;
                const Vec2 from = at + off * Vec2(std::cos(angle), std::sin(angle));
                const HeightJet<Interval> jet = heights.jet(form, Interval(from.x(), from.x() + width),
                                                            Interval(from.y(), from.y() + width));
                return jet.gx.width() + jet.gy.width();
            };
            const double far = blur(1e-2);
            CHECK(std::isfinite(far));
            CHECK(blur(1e-4) < 4 * far);
            CHECK(blur(1e-6) < 4 * far);
        }
    }
}

}  // namespace vcell::radial_base
