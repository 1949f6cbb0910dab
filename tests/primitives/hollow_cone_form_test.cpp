/// The heights of hollow cones over a plane base against distances from the wall.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "../../core/errors.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/forms/exact_heights.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"

namespace vcell::hollow_cone_form_test {
namespace {

Scene scene_of(const Plane& base, std::vector<Object> objects) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    scene.box = {{-1, -1, -1}, {1, 1, 2}};
    return scene;
}

double room(const HollowCone& cone, const Vec3& p) {
    const Vec3 d = p - cone.apex, a = cone.axis.normalized();
    return cone.sine() * d.dot(a) - cone.cosine() * d.cross(a).norm();
}

const FormId first{0};

// The form's number in the family: cylinders come last.
FormId cone_of(const PlaneBaseProblem& problem) {
    REQUIRE(problem.family.cylinders.size() == 1);
    return FormId{static_cast<std::uint32_t>(problem.family.forms.size())};
}

}  // namespace

TEST_CASE(
    "hollow cones: the height's point is equally far from base and wall, and derivatives are the height's") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    int tried = 0, below_tip = 0;
    for (int round = 0; round < long_rounds(400); ++round) {
        CAPTURE(round);
        const Vec3 axis = Vec3(unit(rng), unit(rng), round % 3 == 0 ? 0.0 : unit(rng));
        const HollowCone cone{{unit(rng), unit(rng), 1.5 * unit(rng)}, axis, 1, 1.01 + std::abs(unit(rng))};
        Plane base{{0, 0, 0}, {0, 0, 1}};
        if (round % 2 == 0) base.normal.head<2>() = Vec2(0.3 * unit(rng), 0.2 * unit(rng));
        PlaneBaseProblem problem;
        try {
            problem = plane_base_problem(scene_of(base, {cone}));
        } catch (const InputError& error) {
            CHECK(error.kind == InputError::Kind::EmptyBox);
            continue;
        }
        ++tried;
        const FormId f = cone_of(problem);
        const Heights heights(problem.family);
        for (int k = 0; k < 5; ++k) {
            const double x = unit(rng), y = unit(rng);
            const HeightJet<Wide> at = heights.jet(f, Wide(x), Wide(y));
            const double r = at.v.approximation();
            if (std::abs(r) > 8) continue;
            below_tip += r > 0;
            const Vec3 p = problem.frame.to_world({x, y, r});
            CHECK(room(cone, p) == doctest::Approx(r).epsilon(1e-12).scale(8));
            CHECK(cylinder_height(problem.family.cylinders[0], x, y) ==
                  doctest::Approx(r).epsilon(1e-10).scale(8));
            const auto near = heights.near(f, x, y);
            CHECK(near[0] == doctest::Approx(r).epsilon(1e-10).scale(8));
            CHECK(near[1] == doctest::Approx(at.gx.approximation()).epsilon(1e-8).scale(8));
            CHECK(near[2] == doctest::Approx(at.gy.approximation()).epsilon(1e-8).scale(8));
            // Ranges over a box hold what is in it, and so do derivatives of what differences tell.
            const double size = std::ldexp(1.0, -static_cast<int>(rng() % 30)), step = 0x1p-60;
            const Interval X(x, x + size), Y(y, y + size);
            const HeightJet<Interval> over = heights.jet(f, X, Y);
            const HeightCurvature<Interval> curvature = heights.curvature(f, X, Y);
            const Wide u(x + 0.5 * size), v(y + 0.25 * size), h(step);
            const HeightJet<Wide> inside = heights.jet(f, u, v), right = heights.jet(f, u + h, v),
                                  up = heights.jet(f, u, v + h);
            const auto holds = [](const Interval& range, const Wide& value) {
                const double slop = 1e-12 * (1 + std::abs(value.approximation()));
                return range.lower() <= value.approximation() + slop &&
                       value.approximation() - slop <= range.upper();
            };
            CHECK(holds(over.v, inside.v));
            CHECK(holds(over.gx, inside.gx));
            CHECK(holds(over.gy, inside.gy));
            CHECK(holds(over.gx, (right.v - inside.v) / h));
            CHECK(holds(over.gy, (up.v - inside.v) / h));
            CHECK(holds(curvature.xx, (right.gx - inside.gx) / h));
            CHECK(holds(curvature.xy, (up.gx - inside.gx) / h));
            CHECK(holds(curvature.yy, (up.gy - inside.gy) / h));
        }
    }
    CHECK(tried > long_rounds(100));
    CHECK(below_tip > long_rounds(100));
}

// Half an angle of sine 3 / 5, and the apex 1 below the base: the tip is 3 / 2 high, and on the base the wall
// is 3 / 4 from the axis.
TEST_CASE("hollow cones: heights are compared exactly") {
    const PlaneBaseProblem problem = plane_base_problem(scene_of(
        {{0, 0, 0}, {0, 0, 1}}, {HollowCone{{0, 0, -1}, {0, 0, 2}, 6, 10}, Plane{{0, 0, 3}, {0, 0, 1}}}));
    const FormId cone = cone_of(problem);
    REQUIRE(problem.sites[first][0] == Site::object(1));
    CHECK(problem.axes[0] == AxisToBase::Upright);
    const auto compared = [&](double x, double y) {
        return compare_exactly(problem.family, cone, first, {x, y, 1.0});
    };
    CHECK(compared(0, 0) == Sign::Zero);
    CHECK(compared(0x1p-80, 0) == Sign::Negative);
    CHECK(compared(0.75, 0) == Sign::Negative);
    const HeightEquation on_rim = height_equation(problem.family, cone, {0.75, 0.0, 1.0});
    CHECK(on_rim.c.sign() == Sign::Zero);
}

TEST_CASE("hollow cones: a level line of the wall is told exactly") {
    const auto lean = [](const Vec3& axis, double radius, double slant) {
        return plane_base_problem(
                   scene_of({{0, 0, 0}, {0, 0, 1}}, {HollowCone{{0, 0, -0.25}, axis, radius, slant}}))
            .axes[0];
    };
    CHECK(lean({4, 0, 3}, 3, 5) == AxisToBase::Parallel);
    CHECK(lean({0, -8, 6}, 9, 15) == AxisToBase::Parallel);
    CHECK(lean({4, 0, std::nextafter(3.0, 4.0)}, 3, 5) == AxisToBase::Oblique);
    CHECK(lean({4, 0, 3}, std::nextafter(3.0, 4.0), 5) == AxisToBase::Oblique);
    CHECK(lean({0, 0, 5}, 1, 2) == AxisToBase::Upright);
}

}  // namespace vcell::hollow_cone_form_test
