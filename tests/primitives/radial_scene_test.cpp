// What radial_base_problem() makes of a scene: the frame, what it refuses, hides and merges, and what objects
// stay to each other.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "../../primitives/bases/cylinder_base.hpp"
#include "../../primitives/bases/nested_balls.hpp"
#include "radial_base_checks.hpp"

namespace vcell::radial_scene_test {
using namespace vcell::radial_base;
using Kind = InputError::Kind;

TEST_CASE("radial base: the frame of a cylinder") {
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            Scene scene = scene_of(Cylinder{{0.5, 0.25, 0.125}, 3 * sign * Vec3::Unit(axis), 1}, {});
            scene.box.max[axis] += 4;
            const RadialBaseProblem problem = problem_of(scene);
            const Eigen::Matrix3d& m = problem.frame.rotation;
            CHECK(m.determinant() == 1);
            CHECK(m.row(1) == sign * Vec3::Unit(axis).transpose());
            CHECK(m.cwiseAbs().sum() == 3);
            // The box's centre is the origin along the axis, and the stretch ends on the box.
            CHECK(problem.stretch == std::array{-12.0, 12.0});
            CHECK(problem.sites.size() == 4);
        }
    Random r;
    for (int i = 0; i < 200; ++i) {
        const Vec3 axis = r.direction() * 5;
        const Cylinder base{0.1 * r.vector(), axis, 0.25 * std::abs(r.unit())};
        const Scene scene = scene_of(base, {}, 1);
        const RadialBaseProblem problem = problem_of(scene);
        const Eigen::Matrix3d& m = problem.frame.rotation;
        CHECK((m * m.transpose() - Eigen::Matrix3d::Identity()).norm() < 8 * u);
        CHECK((m * axis.normalized() - Vec3::UnitY()).norm() < 8 * u);
        CHECK(!problem.frame.is_axis_parallel());
        // The end circles lie in the box and touch it.
        for (const double y : problem.stretch) {
            double excess = -1;
            for (int k = 0; k < 360; ++k) {
                const double angle = k * std::numbers::pi / 180;
                const Vec3 p = problem.frame.to_world(
                    Vec3(base.radius * std::sin(angle), y, base.radius * std::cos(angle)));
                excess = std::max({excess, (scene.box.min - p).maxCoeff(), (p - scene.box.max).maxCoeff()});
            }
            CHECK(excess < 8 * u);
            CHECK(excess > -1e-4);
        }
    }
}

TEST_CASE("radial base: objects that touch, contain or lie in the base are errors") {
    const Vec3 o(1, 2, 3);
    const Sphere ball{o, 2};
    const auto at = [&](double x, double y, double z) -> Vec3 { return o + Vec3(x, y, z); };
    const auto check = [](const Object& base, const Object& object, const std::string& text) {
        const InputError error = error_of(scene_of(base, {Sphere{{5, 5, -3}, 0.5}, object}));
        CHECK(error.kind == Kind::TouchesBase);
        CHECK(error.object == 1);
        CAPTURE(error.what());
        CHECK(std::string(error.what()).find(text) != std::string::npos);
    };
    check(ball, Sphere{at(0, 0, 0), 2}, "is the base itself");
    check(ball, Sphere{at(0, 0, 1), 1}, "lies in the base");  // touches from within
    check(ball, Sphere{at(0, 0, 1), 0.5}, "lies in the base");
    check(ball, Sphere{at(0, 0, 1), 3}, "contains the base");  // touches from outside
    check(ball, Sphere{at(0, 0, 1), 4}, "contains the base");
    check(ball, Plane{at(0, 0, 2), {0, 0, 5}}, "touches the base at (1, 2, 5)");
    check(ball, Plane{at(1, 0, 1), {0, 0, 5}}, "cuts the base at (1, 2, 4)");
    check(ball, Plane{at(0, 0, 0), {1, 2, 5}}, "cuts the base");
    check(ball, Cylinder{at(0, 1, 0), {1, 0, 0}, 3}, "contains the base");
    check(ball, Cylinder{at(0, 1.5, 0), {1, 0, 0}, 0.5}, "touches it from within");
    check(Sphere{o, 0}, Sphere{at(1, 0, 0), 1}, "contains the base");
    check(Sphere{o, 0}, Plane{at(1, 0, 0), {0, 1, 0}}, "touches the base");

    const Cylinder tube{o, {0, 0, 2}, 2};
    check(tube, Sphere{at(1, 0, 0), 3.5}, "contains a cross section");
    check(tube, Sphere{at(0, 0, 12), 4}, "contains a cross section");
    check(tube, Sphere{at(1, 0, 3), 1}, "lies in the base");
    check(tube, Plane{at(0, 0, 0), {0, 0, 1}}, "cuts the base");
    check(tube, Plane{at(2, 0, 0), {-3, 0, 0}}, "touches the base");
    check(tube, Plane{at(0, 0, 10), {0, 0, 1}}, "touches the base");
    check(tube, Plane{at(0, 0, 11), {1, 0, 1}}, "cuts the base");
    check(tube, Cylinder{at(0, 0, 5), {0, 0, -1}, 1}, "lies in the base");
    check(tube, Cylinder{at(0, 0, 5), {0, 0, -1}, 3}, "contains a cross section");
    check(tube, Cylinder{at(0, 0, 5), {0, 0, -1}, 2}, "is the base itself");
    check(Cylinder{o, {1, 2, 5}, 0}, Cylinder{at(1, 2, 5), {-1, -2, -5}, 0}, "is the base itself");
    check(tube, Cylinder{at(0, 1, 5), {1, 0, 0}, 1}, "touches it from within");
    check(tube, Cylinder{at(0, 0, 5), {1, 0, 0}, 2}, "contains a cross section");
    check(tube, Cylinder{at(3, 0, 5), {0, 0, 1}, 5}, "contains a cross section");
    // About a point of an axis whose length is no double.
    check(Cylinder{o, {1, 0, 1}, 0.5}, Cylinder{at(1, 0.25, 1), {-1, 0, 1}, 0.25}, "touches it from within");
    check(Cylinder{o, {1, 0, 1}, 0.5}, Sphere{at(2, 0, 2), 0.5}, "contains a cross section");
    check(Cylinder{o, {1, 1, 0}, 0.5}, Sphere{at(-1.5, -1.5, 0), 0.5}, "contains a cross section");
    // A ball in line with the axis beyond the box is not seen: no error.
    const RadialBaseProblem problem = problem_of(scene_of(tube, {Sphere{at(0, 0, 14), 1}}));
    CHECK(!form_of(problem, Site::object(0)).valid());
    REQUIRE(problem.warnings.size() == 1);
    CHECK(problem.warnings[0].find("object 0: out of sight") == 0);
    // Just clear, and just overlapping the surface without containing the base, are fine.
    const double step = 8 * u;
    problem_of(scene_of(ball, {Sphere{at(0, 0, 1), 1 + step}, Plane{at(0, 0, 2 + step), {0, 0, 5}}}));
    problem_of(
        scene_of(tube, {Plane{at(2 + step, 0, 0), {-3, 0, 0}}, Plane{at(0, 0, 10 + 2 * step), {0, 0, 1}}}));
}

TEST_CASE("radial base: the centre, or circles of the base, must lie in the box") {
    const auto fails = [](const Scene& scene) {
        const InputError error = error_of(scene);
        CHECK(error.kind == Kind::EmptyBox);
        CHECK(error.path == "box");
    };
    Scene scene = scene_of(Sphere{{0.1, 0.2, 0.3}, 2}, {});
    scene.box.max.z() = std::nextafter(0.3, 1.0);
    CHECK(problem_of(scene).sites.size() == 6);  // the ball may reach beyond its sides
    scene.box.max.z() = 0.3;
    fails(scene);
    std::get<Sphere>(scene.base).radius = 0;
    fails(scene);
    scene.box.max.z() = std::nextafter(0.3, 0.0);
    fails(scene);
    scene = scene_of(Cylinder{{0, 0, 0}, {0, 1, 0}, 2}, {});
    scene.box.max.x() = 2;
    CHECK(problem_of(scene).stretch == std::array{-10.0, 10.0});
    scene.box.max.x() = 0x1p-40;  // along a side it may reach beyond that
    CHECK(problem_of(scene).stretch == std::array{-10.0, 10.0});
    scene.box.max.x() = std::nextafter(0.0, 1.0);
    CHECK(error_of(scene).kind == Kind::OutOfRange);
    scene.box.max.x() = 0;
    fails(scene);
    std::get<Cylinder>(scene.base).radius = 0;
    fails(scene);
    scene.box.max.x() = -1;
    fails(scene);
    scene.box.max.x() = 10;
    scene.base = Cylinder{{-9, -9, -9}, {1, -1, 0}, 2};  // cuts a corner
    fails(scene);
}

TEST_CASE("radial base: objects in others are hidden, equal ones merged") {
    const Sphere ball{{1, 1, 1}, 1};
    const RadialBaseProblem problem =
        problem_of(scene_of(ball, {Sphere{{5, 1, 1}, 1.5},                 // 0
                                   Sphere{{5.5, 1, 1}, 1},                 // 1 touches 0 from within
                                   Sphere{{5, 1, 1}, 1.5},                 // 2 equals 0
                                   Sphere{{5.5000001, 1, 1}, 1},           // 3 is not in 0
                                   Cylinder{{1, 6, 1}, {1, 0, 0}, 1},      // 4
                                   Cylinder{{-9, 6, 1}, {-3, 0, 0}, 1},    // 5 equals 4
                                   Cylinder{{0, 6.5, 1}, {2, 0, 0}, 0.5},  // 6 touches 4 from within
                                   Sphere{{2, 6, 1}, 1},                   // 7 fills a stretch of 4
                                   Plane{{1, 1, -6}, {0, 0, 1}},           // 8
                                   Plane{{9, 9, -6}, {0, 0, -7}},          // 9 equals 8
                                   Cylinder{{3, 3, -7}, {1, 1, 0}, 1},     // 10 touches 8 from behind
                                   Sphere{{5.5, 1, 1}, 1}}));              // 11 equals 1
    std::vector<std::vector<Site>> groups;
    for (const FormId f : problem.sites.ids()) groups.push_back(sites_of(problem, f));
    const auto group = [](std::initializer_list<std::uint32_t> objects) {
        std::vector<Site> sites;
        for (const std::uint32_t i : objects) sites.push_back(Site::object(i));
        return sites;
    };
    REQUIRE(groups.size() == 4 + 6);
    CHECK(groups[0] == group({0, 2}));
    CHECK(groups[1] == group({3}));
    CHECK(groups[2] == group({8, 9}));
    CHECK(groups[3] == std::vector{Site::box_side(0)});
    CHECK(groups[9] == group({4, 5}));
    REQUIRE(problem.warnings.size() == 4);
    CHECK(problem.warnings[0] ==
          "object 1 in object 0, object 6 in object 4, object 7 in object 4, object 10 beyond object 8, "
          "object 11 in "
          "object 0: hidden, never nearest to any point of the cell");
    CHECK(problem.warnings[1] == "object 0 and object 2: the same distance from the base everywhere, merged");
    CHECK(std::get<Sphere>(problem.objects[FormId{0}]).center == Vec3(4, 0, 0));
}

TEST_CASE("radial base: what a side of the box mirrors to the base has the side's height") {
    // The side +x is 10 away from the base.
    Scene scene =
        scene_of(Sphere{{1, 1, 1}, 2}, {Sphere{{21, 1, 1}, 2}, Sphere{{21, 1, 1}, 1}, Sphere{{1, 1, 22}, 2}});
    RadialBaseProblem problem = problem_of(scene);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(0), Site::box_side(1)});
    CHECK(problem.sites.size() == 2 + 5);  // object 1 lies in object 0
    CHECK(sites_of(problem, FormId{1}) == std::vector{Site::object(2)});

    scene = scene_of(
        Cylinder{{1, 1, 1}, {0, 0, 1}, 2},
        {Cylinder{{21, 1, -8}, {0, 0, -3}, 2}, Sphere{{21, 1, 4}, 2}, Cylinder{{1, 20, 7}, {0, 0, 2}, 1},
         Plane{{-19, 0, 0}, {1, 0, 0}}, Cylinder{{1, -19.5, 0}, {0, 0, 1}, 1}});
    problem = problem_of(scene);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(0), Site::box_side(1)});
    CHECK(form_of(problem, Site::object(1)) == FormId{});  // in object 0
    CHECK(form_of(problem, Site::object(2)) == form_of(problem, Site::object(2)));
    CHECK(form_of(problem, Site::object(4)) == FormId{});  // in the image beyond -y
    CHECK(problem.warnings.front().find("object 4 beyond side box:-y") != std::string::npos);
}

TEST_CASE(
    "radial base: a huge ball that has the height of a plane with a rounded normal is told from the plane") {
    // |n| = sqrt(3) would be rounded down to l. A ball (c, delta) with 2 c / C = -n / D and 2 delta / C = l /
    // D, that is C = |c|^2 - delta^2 = 4 D^2 / (3 - l^2), would be as near as the plane everywhere.
    const double l = std::sqrt(3.0), D = (Exact(3.0) - Exact(l) * l).enclosure().mid();
    REQUIRE(Exact(D) == Exact(3.0) - Exact(l) * l);
    // Scaled by 2^52: c = -2 n, delta = 2 l, D = 3 - l^2, about 3e-16.
    const double scale = 0x1p50;
    const Scene scene = scene_of(Sphere{{0, 0, 0}, 0}, {Plane{{D * scale, 0, 0}, {-1, -1, -1}},
                                                        Sphere{2 * scale * Vec3::Ones(), 2 * scale * l},
                                                        Plane{{-1, 0, 0}, {1, 0, 0}}});
    const RadialBaseProblem problem = problem_of(scene);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(0)});
    CHECK(sites_of(problem, FormId{1}) == std::vector{Site::object(1)});
    CHECK(problem.sites.size() == 3 + 6);
}

TEST_CASE("radial base: cylinders of one radius that cross are told from those that all but cross") {
    const Vec3 c(3, 4, -2), a(1, 2, -1), b(2, -1, 3);
    const auto cross = [&](const Object& base, const Object& first, const Object& second) {
        const RadialBaseProblem problem = problem_of(scene_of(base, {first, second}));
        const FormId f = form_of(problem, Site::object(0)), g = form_of(problem, Site::object(1));
        CHECK(problem.cross_equally(f, g) == problem.cross_equally(g, f));
        return problem.cross_equally(f, g);
    };
    for (const Object& base :
         {Object(Sphere{{0.1, 0.2, 0.3}, 0.5}), Object(Cylinder{{0.125, 0.25, 0}, {0, 0, 1}, 0.5}),
          Object(Cylinder{{0.125, 0, 0.25}, {0, 1, 0}, 0.5}),
          Object(Cylinder{{0.1, 0.2, 0.3}, {0, -0.3, 1}, 0.5}),
          Object(Cylinder{{0, 0.1, 0}, {0.2, 1, 0.1}, 0.5})}) {
        CAPTURE(base.index());
        CHECK(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c - b, -2 * b, 0.25}));
        const Vec3 up = std::ldexp(1.0, -44) * Vec3::UnitX();
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c - b + up, b, 0.25}));
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c - b, b, 0.25 + 0x1p-50}));
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c + Vec3(0, 1, 0), a, 0.25}));
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Sphere{c + Vec3(0, 1, 0), 0.25}));
    }
}

TEST_CASE("radial base: a tube of the base's radius whose axis crosses its own is two walls") {
    const Vec3 crossing(0.5, -1, 2);
    for (const Vec3& along : {Vec3(0, 0, 1), Vec3(0, -2, 0), Vec3(1, 1, 0), Vec3(1, -2, 3)})
        for (const Vec3& across : {Vec3(1, 0, 0), Vec3(-1, 1, 2), Vec3(3, 2, -1)})
            for (const double before : {-8.0, 8.0}) {
                const Cylinder base{crossing + before * along, along, 0.25};
                const Cylinder tube{crossing - across, 2 * across, 0.25};
                Scene scene = scene_of(base, {tube, tube}, 3);
                scene.box = {base.point + scene.box.min, base.point + scene.box.max};
                const std::vector<TubeCrossing> crossings = crossing_tubes(scene, base);
                REQUIRE(crossings.size() == 2);
                const RadialBaseProblem problem = problem_of(scene);
                CHECK((problem.frame.to_world({0, crossings[0].y, 0}) - crossing).norm() < 1e-13);
                int walls = 0;
                for (const FormId f : problem.sites.ids()) {
                    if (problem.sites[f].front() != Site::object(0)) continue;
                    // Its twin has both, too.
                    CHECK(sites_of(problem, f) == std::vector{Site::object(0), Site::object(1)});
                    CHECK(is_wall(problem, f));
                    CHECK(bisector_name(problem, f) == "plane");
                    const auto& wall = std::get<Plane>(problem.objects[f]);
                    CHECK(wall.normal.dot(Vec3(0, 0.5 * (problem.stretch[0] + problem.stretch[1]), 0) -
                                          wall.point) < 0);
                    // Its points are as far from one axis as from the other.
                    const Vec3 aside = wall.normal.unitOrthogonal();
                    for (const Vec3& way : {aside, Vec3(aside.cross(wall.normal))}) {
                        const Vec3 p = problem.frame.to_world(wall.point + 3 * way) - crossing;
                        CHECK(p.cross(along.normalized()).norm() ==
                              doctest::Approx(p.cross(across.normalized()).norm()).epsilon(1e-14));
                    }
                    ++walls;
                }
                CHECK(walls == 2);
                // Those that all but cross are tubes.
                scene.objects = {Cylinder{tube.point + 0x1p-44 * along.cross(across), across, 0.25},
                                 Cylinder{tube.point, across, 0.25 + 0x1p-50}};
                CHECK(crossing_tubes(scene, base).empty());
            }
}

TEST_CASE("radial base: a tilted cylinder leaves alone what objects are to each other") {
    // Integers, whatever direction they are measured in: touching from within, equal, parallel, mirrored.
    for (const Vec3& axis : {Vec3(1, 1, 0), Vec3(-3, 2, 0), Vec3(4, -3, 0), Vec3(-1, -7, 0)}) {
        CAPTURE(axis.transpose());
        const Vec3 c = 2 * Vec3(-axis.y(), axis.x(), 3), p(0.1, 0.2, 0);
        const Scene scene =
            scene_of(Cylinder{p, axis, 0.5}, {Sphere{c, 1},                        // 0
                                              Sphere{c + Vec3(0, 0, 0.75), 0.25},  // 1 touches 0 from within
                                              Cylinder{-c, Vec3(3, 1, 2), 1},      // 2
                                              Cylinder{-c - Vec3(3, 1, 2), -Vec3(6, 2, 4), 1},  // 3 equals 2
                                              Cylinder{Vec3(5, 5, 5), axis, 0.25},              // 4
                                              Cylinder{p + Vec3(0, 0, 20), -2 * axis, 0.5}});   // 5 mirrored
        const RadialBaseProblem problem = problem_of(scene);
        const auto form = [&](std::uint32_t i) { return form_of(problem, Site::object(i)); };
        CHECK(form(1) == FormId{});
        CHECK(form(2) == form(3));
        CHECK(problem.family.radial_form(form(2)).has_root());
        CHECK(!problem.family.radial_form(form(4)).has_root());
        CHECK(std::get<Cylinder>(problem.objects[form(4)]).axis == Vec3::UnitY());
        CHECK(form(5) == form_of(problem, Site::box_side(5)));
    }
}

TEST_CASE("radial base: where balls overlap the base its clearance is negative") {
    const Sphere base{{0, 0, 0}, 2}, other{{3, 0, 0}, 2};
    const RadialBaseProblem problem = problem_of(scene_of(base, {other}));
    // C = 9, Q = 2 c.u / C.
    const Vec2 p = problem.chart.chart_point({0.96, 0.28, 0}, 0);
    const double t = problem.chart.distance_of(p, problem.family.forms[FormId{0}](p.x(), p.y()));
    CHECK(t == doctest::Approx(1.5625).epsilon(1e-14));
    CHECK(t - problem.chart.radius == doctest::Approx(-0.4375).epsilon(1e-14));
    const RadialBaseProblem tube = problem_of(scene_of(Cylinder{{0, 0, 0}, {0, 1, 0}, 2}, {other}));
    const Real q =
        nearness(tube.family, FormId{0}, tube.chart.chart_point(tube.frame.rotation * Vec3(1, 0, 0), 0));
    CHECK((1 / q).convert_to<double>() == doctest::Approx(1.5).epsilon(1e-14));
}

TEST_CASE("nested balls: as comparing all pairs exactly tells") {
    Random r;
    for (int round = 0; round < long_rounds(60); ++round) {
        std::vector<Ball> balls;
        const int count = 1 + static_cast<int>(r.rng() % 400);
        const double scale = r.pick({1e-30, 1, 1e30});
        // Radii of all sizes make many pairs; alike, they leave few that could be nested.
        const bool alike = round % 3 == 0;
        for (int i = 0; i < count; ++i) {
            // Multiples of 1/4: many touch from within; one ulp more or less decides.
            const auto grid = [&] { return scale * std::round(16 * r.unit()) / 4; };
            const double rho = alike ? scale * r.pick({2, 2.25}) : std::abs(grid());
            Ball ball{grid(), grid(), alike || round % 2 ? 0 : grid(), rho};
            if (r.rng() % 4 == 0) ball.rho = std::nextafter(ball.rho, r.pick({0, 1e60}));
            balls.push_back(i > 0 && r.rng() % 16 == 0 ? balls[r.rng() % balls.size()] : ball);
        }
        const auto lies_in = [](const Ball& in, const Ball& out) {
            const Exact x = Exact(in.cx) - out.cx, y = Exact(in.cy) - out.cy, z = Exact(in.cz) - out.cz,
                        gap = Exact(out.rho) - in.rho;
            return gap.sign() == Sign::Positive &&
                   (gap * gap - x * x - y * y - z * z).sign() != Sign::Negative;
        };
        const BallNesting found = ball_nesting(balls);
        int nested = 0;
        for (std::size_t i = 0; i < balls.size(); ++i) {
            std::uint32_t first = UINT32_MAX, enclosing = UINT32_MAX;
            for (std::uint32_t k = 0; k < balls.size(); ++k) {
                if (first == UINT32_MAX && balls[k] == balls[i]) first = k;
                if (lies_in(balls[i], balls[k]) &&
                    (enclosing == UINT32_MAX || balls[k].rho > balls[enclosing].rho))
                    enclosing = k;
            }
            nested += enclosing != UINT32_MAX;
            CHECK(found.first_equal[i] == first);
            CHECK(found.enclosing[i] == enclosing);
        }
        if (count > 100) CHECK(nested > 0);
    }
    CHECK(ball_nesting({}).first_equal.empty());
}

}  // namespace vcell::radial_scene_test
