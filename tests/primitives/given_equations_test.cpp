// The equations of what was given around a turned tube hold, to its rounding, where the turned forms have
// their heights.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../../primitives/forms/space_quadrics.hpp"
#include "../test_support.hpp"
#include "radial_base_checks.hpp"

namespace vcell::given_equations_test {
using namespace vcell::radial_base;

// The result encloses the quadric's values all over X.
Interval value(const space_quadrics::Quadric& q, const std::array<Interval, 5>& X) {
    Interval sum(0.0);
    for (std::size_t i = 0; i < X.size(); ++i)
        for (std::size_t j = i; j < X.size(); ++j)
            sum = sum + q[space_quadrics::term(X.size(), i, j)].enclosure() * X[i] * X[j];
    return sum;
}

TEST_CASE("given equations: they hold where forms around a turned tube have their heights") {
    Random r;
    int asked = 0, balls = 0, tubes = 0, sides = 0;
    for (int round = 0; round < long_rounds(100); ++round) {
        const Vec3 axis(r.pick({1, 3}), r.pick({1, 3}), -1);  // no length of these is rational
        const Cylinder base{r.vector(), axis, 0.25};
        std::vector<Object> objects;
        for (int i = 0; i < 6; ++i) objects.push_back(random_round_beside(r, base, i));
        const RadialBaseProblem problem = problem_of(scene_of(base, objects, 4));
        const FormFamily& family = problem.family;
        REQUIRE(family.given);
        REQUIRE_FALSE(family.tips.any());
        const Heights heights(family);
        for (std::uint32_t f = 0; f < family.size(); ++f) {
            const auto equation = family.given->of(FormId{f});
            if (!equation) continue;
            const auto [low, high] = problem.stretch;
            const double around = 1 + 2 * r.unit(), far = 0.5 * (low + high + r.unit() * (high - low));
            const Interval x(around), y(far / family.axial_unit), height = heights.value(FormId{f}, x, y);
            if (height.sign() != family.compared_over().sign_of_met()) continue;
            const auto X = space_quadrics::places(family, x, y, height);
            for (const auto& q : {family.given->base, *equation}) {
                const Interval v = value(q, X);
                CHECK(v.contains(0));
                CHECK(v.width() < 1e-6 * (1 + square(X[3]).upper()));
            }
            ++asked;
            const Object& object = problem.given[FormId{f}];
            balls += std::holds_alternative<Sphere>(object);
            tubes += std::holds_alternative<Cylinder>(object);
            sides += std::holds_alternative<Plane>(object);
        }
    }
    CHECK(asked > 100);
    CHECK(balls > 10);
    CHECK(tubes > 10);
    CHECK(sides > 10);
}

}  // namespace vcell::given_equations_test
