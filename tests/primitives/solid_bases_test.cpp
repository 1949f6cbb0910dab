// Bases among solids that overlap: what is left out has no point that is as far from all three.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "../../core/errors.hpp"
#include "../../primitives/bases/cylinder_base.hpp"
#include "../../primitives/bases/feet.hpp"
#include "../../primitives/bases/solid_bases.hpp"
#include "../../primitives/bisectors/trisector.hpp"
#include "reference.hpp"
#include "test_support.hpp"

namespace vcell::solid_bases_test {

namespace {

double signed_distance(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object))
        return plane->normal.normalized().dot(p - plane->point);
    return distance(object, p);
}

// Where the ray from f along w is as far from the object as from the base, R0 less than t; by bisection.
double height(const Object& object, const Vec3& f, const Vec3& w, double R0) {
    double low = 0, high = 1e3;
    if (signed_distance(object, f) + R0 < 0) return 0;
    for (int i = 0; i < 200; ++i) {
        const double t = 0.5 * (low + high);
        (signed_distance(object, f + t * w) > t - R0 ? low : high) = t;
    }
    return low;
}

Scene scene_of(const Cylinder& tube, const Object& a, const Object& b) {
    Scene scene;
    scene.base = tube;
    scene.objects = {a, b};
    scene.box = box_with_feet(tube, {{-4, -4, -4}, {4, 4, 4}});
    return scene;
}

}  // namespace

TEST_CASE("solid bases: parts of an axis that are left out have nothing") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    int left_out = 0;
    for (int round = 0; round < 60 * rounds(); ++round) {
        const double R0 = round % 3 == 0 ? 0 : 0.2 + 0.1 * unit(rng);
        const auto other = [&](int kind) -> Object {
            const Vec3 p = vector(), d = vector();
            if (kind == 0) return Plane{p, d};
            if (kind == 1) return Sphere{p, R0 + 0.5 + 0.4 * unit(rng)};
            return Cylinder{p, d, R0 + 0.5 + 0.4 * unit(rng)};
        };
        const std::array<Object, 2> others{other(round % 3), other(round / 3 % 3)};
        const Scene scene = scene_of({vector(), vector(), R0}, others[0], others[1]);
        const SolidProblems problems = solid_problems(scene, 1);
        Scene alone = scene;
        alone.objects.clear();
        const RadialBaseProblem all = cylinder_base_problem(alone, std::get<Cylinder>(scene.base), 1);
        std::uniform_real_distribution<double> along(all.stretch[0], all.stretch[1]), turn(0, 7);
        for (int sample = 0; sample < 100; ++sample) {
            const double y = along(rng), angle = turn(rng);
            if (std::ranges::any_of(problems.parts, [&](const RadialBaseProblem& part) {
                    return y > part.stretch[0] && y < part.stretch[1];
                }))
                continue;
            ++left_out;
            const Vec3 f = all.frame.to_world({0, y, 0}),
                       w = all.frame.rotation.transpose() * Vec3(std::sin(angle), 0, std::cos(angle));
            const std::array t{height(others[0], f, w, R0), height(others[1], f, w, R0)};
            const bool has_nothing = t[0] < 0.99 * t[1] || t[1] < 0.99 * t[0] || std::min(t[0], t[1]) < R0 ||
                                     std::min(t[0], t[1]) == 0;
            CHECK(has_nothing);
        }
    }
    CHECK(left_out > 500 * rounds());
}

TEST_CASE("solid bases: what is left of an axis, in closed form") {
    // Along a line through the middle of a ball of radius 1 its height is (y^2 - 1) / 2.
    const Cylinder line{{0, 0, 0}, {0, 0, 1}, 0};
    const Sphere ball{{0, 0, 0}, 1};
    const SolidProblems through = solid_problems(scene_of(line, ball, Sphere{{3, 0, 0}, 0.5}), 1);
    REQUIRE(through.parts.size() == 2);
    // The other ball is 2.5 and more away: as much is left out as has heights of 5/8 at most.
    for (const auto& [end, sign] :
         {std::pair(through.parts[0].stretch[1], -1), std::pair(through.parts[1].stretch[0], 1)}) {
        CHECK(sign * end > 1.2);
        CHECK(sign * end < std::sqrt(2.25) + 0.1);
    }
    // Behind a plane across it there is nothing.
    const SolidProblems before = solid_problems(scene_of(line, ball, Plane{{0, 0, -2}, {0, 0, 1}}), 1);
    REQUIRE(before.parts.size() == 2);
    CHECK(before.parts[0].stretch[0] > -2);
    CHECK(before.parts[0].stretch[1] < -1);
    // All of a tube, and none.
    const Cylinder tube{{0, 0, 0}, {0, 0, 1}, 0.5};
    CHECK(solid_problems(scene_of(tube, Sphere{{3, 0, 0}, 0.75}, Plane{{-2, 0, 0}, {1, 0, 0}}), 1)
              .parts.size() == 1);
    CHECK(solid_problems(scene_of(tube, Cylinder{{0.25, 0, 0}, {0, 0, 2}, 1}, ball), 1).parts.empty());
    // A plane is as far from it as the tube is thick, and moves by rounding alone.
    const SolidProblems drawn = solid_problems(scene_of(tube, ball, Plane{{0, 0.25, 0}, {0, 1, 0}}), 1);
    CHECK(std::get<Cylinder>(drawn.scene.base).radius == 0);
    CHECK(std::get<Plane>(drawn.scene.objects[1]).point.y() == -0.25);
    CHECK(drawn.moved < 1e-14);
}

TEST_CASE("solid bases: surfaces that are one, touch along a line, or are apart") {
    const Plane ground{{0, 0, 0}, {0, 0, 1}};
    const Cylinder below{{0, 0, -0.5}, {1, 0, 0}, 0.5}, around{{0, 0, -0.75}, {-2, 0, 0}, 0.75};
    const Sphere above{{0, 1, 1}, 0.25}, under{{0, 0, -0.5}, 0.25};
    CHECK(is_same_surface(ground, Plane{{3, 4, 0}, {0, 0, -7}}));
    CHECK(is_same_surface(below, Cylinder{{0.1, 0, -0.5}, {-0.3, 0, 0}, 0.5}));
    CHECK_FALSE(is_same_surface(below, around));
    CHECK_FALSE(is_same_surface(ground, Plane{{0, 0, 1e-300}, {0, 0, 1}}));
    CHECK(touch_along_line({ground, below, above}));
    CHECK(touch_along_line({above, around, below}));
    CHECK_FALSE(touch_along_line({ground, below, under}));
    CHECK_FALSE(touch_along_line({Plane{{0, 0, 0}, {0, 0, -1}}, below, above}));
    CHECK(are_certainly_apart(above, below));
    CHECK_FALSE(are_certainly_apart(under, below));
    CHECK(are_certainly_apart(below, Cylinder{{0, 3, 1}, {0, 1, 0}, 0.75}));
    CHECK_FALSE(are_certainly_apart(below, Cylinder{{0, 3, 1}, {0, 1, 0}, 1.25}));
    CHECK_FALSE(are_certainly_apart(ground, above));
}

TEST_CASE("solid bases: components seen from outside alone") {
    // Of three planes one line for each choice of sides, of balls nothing at distances below 0.
    const Plane x{{0, 0, 0}, {1, 0, 0}}, y{{0, 0, 0}, {0, 1, 0}}, z{{0, 0, 0}, {0, 0, 1}};
    const Trisector planes = trisector_of_solids(x, y, z);
    REQUIRE(planes.components.size() == 1);
    CHECK(planes.components[0].direction.cwiseAbs().isApprox(Vec3::Constant(1 / std::sqrt(3.0))));
    CHECK(planes.components[0].direction.minCoeff() * planes.components[0].direction.maxCoeff() > 0);
    CHECK(trisector(x, y, z).components.size() == 4);
    const Sphere large{{0, 0, 0}, 3}, small{{1, 0, 0}, 1}, other{{0, 1, 0}, 0.5};
    CHECK(trisector_of_solids(large, small, other).components.empty());
}

}  // namespace vcell::solid_bases_test
