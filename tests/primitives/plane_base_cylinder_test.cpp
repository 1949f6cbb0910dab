#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <random>

#include "../../core/errors.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/solids.hpp"
#include "problem_sites.hpp"
#include "test_support.hpp"

namespace vcell::plane_base_cylinder_test {
using Kind = InputError::Kind;
using Real = boost::multiprecision::cpp_bin_float_100;

namespace {

// The square [-1,1]^2 under a lid at z = 2.
Scene square_scene(std::vector<Object> objects) {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = std::move(objects);
    scene.box = {{-1, -1, 0}, {1, 1, 2}};
    return scene;
}

PlaneBaseProblem problem_of(std::vector<Object> objects) {
    const Scene scene = square_scene(std::move(objects));
    validate(scene);
    return plane_base_problem(scene);
}

std::string complaint(std::vector<Object> objects) {
    try {
        problem_of(std::move(objects));
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

std::vector<Site> objects(const std::vector<std::uint32_t>& ids) {
    std::vector<Site> sites;
    for (const std::uint32_t i : ids) sites.push_back(Site::object(i));
    return sites;
}

// Distance of (x, y, z) from the cylinder's surface, negative inside.
Real distance(const CylinderForm& f, const Real& x, const Real& y, const Real& z) {
    const Real mx = x - f.px, my = y - f.py, mz = z - f.pz;
    const Real cx = my * f.az - mz * f.ay, cy = mz * f.ax - mx * f.az, cz = mx * f.ay - my * f.ax;
    const Real norm = Real(f.ax) * f.ax + Real(f.ay) * f.ay + Real(f.az) * f.az;
    return sqrt((cx * cx + cy * cy + cz * cz) / norm) - f.rho;
}

// The least distance of the cylinder from the square [-1,1]^2 of the base: nested golden-section
// searches, as the distance from a convex body is convex.
double least_distance(const CylinderForm& f) {
    const auto minimum = [](const auto& g) {
        const double ratio = 0.5 * (std::sqrt(5.0) - 1);
        double a = -1, b = 1, least = std::min(g(a), g(b));
        for (int i = 0; i < 80; ++i) {
            const double c = b - ratio * (b - a), d = a + ratio * (b - a);
            const double gc = g(c), gd = g(d);
            least = std::min({least, gc, gd});
            (gc < gd ? b : a) = gc < gd ? d : c;
        }
        return least;
    };
    return minimum([&](double x) {
        return minimum([&](double y) {
            const double mx = x - f.px, my = y - f.py, mz = -f.pz;
            const Vec3 axis(f.ax, f.ay, f.az);
            return Vec3(mx, my, mz).cross(axis).norm() / axis.norm() - f.rho;
        });
    });
}

}  // namespace

TEST_CASE("cylinders: forms follow the circular ones and keep the canonical doubles") {
    const PlaneBaseProblem problem =
        problem_of({Cylinder{{0.25, 0, 1}, {4, 1, 0}, 0.125}, Sphere{{0, 0, 1.5}, 0.1},
                    Cylinder{{3, 0, 1}, {0.5, 0.25, 1}, 0.5}});
    REQUIRE(problem.family.forms.size() == 2);
    REQUIRE(problem.family.size() == 4);
    REQUIRE(problem.sites.size() == 4);
    CHECK(sites_of(problem, FormId{0}) == objects({1}));
    CHECK(sites_of(problem, FormId{1}) == std::vector{Site::box_side(5)});
    CHECK(sites_of(problem, FormId{2}) == objects({0}));
    CHECK(sites_of(problem, FormId{3}) == objects({2}));
    CHECK(problem.warnings.empty());
    const CylinderForm& f = problem.family.cylinder(FormId{2});
    CHECK(std::array{f.px, f.py, f.pz, f.ax, f.ay, f.az, f.rho} ==
          std::array{0.25, 0.0, 1.0, 0.5, 0.125, 0.0, 0.125});
}

TEST_CASE("cylinders: the height's point is equally far from base and cylinder") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    int tried = 0;
    for (int round = 0; round < 400; ++round) {
        const Cylinder cylinder{{unit(rng), unit(rng), 1 + unit(rng)},
                                std::ldexp(1.0, static_cast<int>(rng() % 60) - 30) *
                                    Vec3(unit(rng), unit(rng), round % 3 == 0 ? 0.0 : unit(rng)),
                                round % 5 == 0 ? 0 : 0.3 + 0.3 * unit(rng)};
        Scene scene = square_scene({cylinder});
        if (round % 2 == 0) {
            scene.base = Plane{{0, 0, 0}, {0.3 * unit(rng), 0.2 * unit(rng), 1}};
            scene.box.min.z() = -1;
        }
        PlaneBaseProblem problem;
        try {
            problem = plane_base_problem(scene);
        } catch (const InputError& error) {
            CHECK(error.kind == Kind::TouchesBase);
            continue;
        }
        if (problem.family.cylinders.empty()) continue;
        ++tried;
        const CylinderForm& f = problem.family.cylinders[0];
        // The same cylinder as the user's, up to the rounding of the frame.
        const Vec3 world = problem.frame.to_world({f.px, f.py, f.pz});
        CHECK((world - cylinder.point).norm() < 1e-15 * 8);
        CHECK((problem.frame.rotation.transpose() * Vec3(f.ax, f.ay, f.az)).cross(cylinder.axis).norm() <=
              1e-15 * 64 * cylinder.axis.norm());
        const double x = 0.5 * unit(rng), y = 0.5 * unit(rng);
        const Real r = cylinder_height(f, Real(x), Real(y));
        CHECK(r > 0);
        CHECK(abs(distance(f, x, y, r) - r) <= Real(1e-80) * r);
    }
    CHECK(tried > 100);
}

TEST_CASE(
    "cylinders: over a base whose normal has no length in doubles, touching is what it is in the scene") {
    // Lines through a point of a side of the region, and past it.
    int tried = 0;
    for (const Vec3& normal : {Vec3(-1, -1, 1), Vec3(1, 2, -2.5), Vec3(3, -1, 1), Vec3(0.5, 0.25, 1)})
        for (const double y : {-2.0, -0.5, 0.0, 1.0, 2.5})
            for (const Vec3& along : {Vec3(1, 1, 0), Vec3(1, 0, 3), Vec3(-2, 1, 1)})
                for (const double beyond : {0.0, 0x1p-30}) {
                    // On the base, x = 3 or a little more; z is exact where its digits are few.
                    const double x = 3 + beyond, z = -(normal.x() * x + normal.y() * y) / normal.z();
                    if (std::abs(z) >= 3 ||
                        Exact(z) * normal.z() != -(Exact(normal.x()) * x + Exact(normal.y()) * y))
                        continue;
                    if (normal.dot(along) == 0) continue;
                    Scene scene;
                    scene.base = Plane{{0, 0, 0}, normal};
                    scene.objects = {Cylinder{{x, y, z}, along, 0}};
                    scene.box = {Vec3::Constant(-3), Vec3::Constant(3)};
                    std::string what = "accepted";
                    try {
                        plane_base_problem(scene);
                    } catch (const InputError& error) {
                        CHECK(error.kind == Kind::TouchesBase);
                        what = error.what();
                    }
                    ++tried;
                    if (beyond == 0)
                        CHECK(what.find("touches the base region at (") != std::string::npos);
                    else
                        CHECK(what == "accepted");
                }
    CHECK(tried > 40);
}

TEST_CASE("cylinders: cutting and touching the base region is exact to the last bit") {
    const auto below = [](double x) { return std::nextafter(x, 0.0); };
    // Parallel to the base, above it; and with its lowest line at a corner or along a side.
    CHECK(complaint({Cylinder{{0, 0.5, 1}, {1, 0, 0}, below(1)}}) == "accepted");
    CHECK(complaint({Cylinder{{0, 0.5, 1}, {1, 0, 0}, 1}}) ==
          "objects[0].cylinder: touches the base region at (1, 0.5, 0)");
    CHECK(complaint({Sphere{{0, 0, 1}, 0.1}, Cylinder{{0, 0.5, 0.5}, {1, 0, 0}, 1}})
              .find("objects[1].cylinder: cuts the base region at (") == 0);
    CHECK(complaint({Cylinder{{0, 5, 3}, {1, 0, 0}, 5}}).find("touches the base region at (") !=
          std::string::npos);
    CHECK(complaint({Cylinder{{0, 5, 3}, {1, 0, 0}, below(5)}}) == "accepted");
    CHECK(complaint({Cylinder{{5, 5, 4}, {1, -1, 0}, std::sqrt(48.0)}}) ==
          (Exact(std::sqrt(48.0)) * std::sqrt(48.0) < Exact(48.0)
               ? "accepted"
               : "objects[0].cylinder: cuts the base region at (1, 1, 0)"));
    // Upright: its trace is a disk. Inside the region, around a corner (3-4-5), beside a side.
    CHECK(complaint({Cylinder{{0.25, 0.5, 7}, {0, 0, 3}, 0.1}}) ==
          "objects[0].cylinder: cuts the base region at (0.25, 0.5, 0)");
    CHECK(complaint({Cylinder{{0.25, 0.5, 7}, {0, 0, 3}, 0}}) ==
          "objects[0].cylinder: touches the base region at (0.25, 0.5, 0)");
    CHECK(complaint({Cylinder{{4, 5, 1}, {0, 0, 1}, 5}}) ==
          "objects[0].cylinder: touches the base region at (1, 1, 0)");
    CHECK(complaint({Cylinder{{4, 5, 1}, {0, 0, 1}, below(5)}}) == "accepted");
    CHECK(complaint({Cylinder{{-3, 0.5, 1}, {0, 0, -1}, 2}}) ==
          "objects[0].cylinder: touches the base region at (-1, 0.5, 0)");
    CHECK(complaint({Cylinder{{-3, 0.5, 1}, {0, 0, -1}, below(2)}}) == "accepted");
    // A line through a point of a side, and one just outside.
    CHECK(complaint({Cylinder{{2, 0.25, 1}, {1, 0, 1}, 0}}) ==
          "objects[0].cylinder: touches the base region at (1, 0.25, 0)");
    CHECK(complaint({Cylinder{{std::nextafter(2.0, 3.0), 0.25, 1}, {1, 0, 1}, 0}}) == "accepted");
    // Tilted towards the region, meeting the base outside it: the trace's half axis along x is 5/4.
    CHECK(complaint({Cylinder{{3.5, 0, 0}, {3, 0, 4}, 2}}) ==
          "objects[0].cylinder: touches the base region at (1, 0, 0)");
    CHECK(complaint({Cylinder{{3.5, 0, 0}, {3, 0, 4}, below(2)}}) == "accepted");
    CHECK(complaint({Cylinder{{3.5, 0, 0}, {3, 0, 4}, std::nextafter(2.0, 3.0)}}) ==
          "objects[0].cylinder: cuts the base region at (1, 0, 0)");
}

TEST_CASE("cylinders: touching agrees with the least distance from the region") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    int clear = 0, cut = 0;
    for (int round = 0; round < 300; ++round) {
        CylinderForm f{2 * unit(rng), 2 * unit(rng), unit(rng), unit(rng), unit(rng), unit(rng), 0};
        if (round % 3 == 0) f.az = 0;
        if (round % 4 == 0) f.ax = 0;
        const double reach = least_distance(f);
        // The same cylinder, 1e-12 short of the region and as much beyond it.
        if (reach < 1e-9) continue;  // the axis itself meets the region
        for (const double excess : {-1e-12, 1e-12}) {
            const double rho = reach + excess;
            const std::string text = complaint({Cylinder{{f.px, f.py, f.pz}, {f.ax, f.ay, f.az}, rho}});
            CAPTURE(f.px);
            CAPTURE(f.py);
            CAPTURE(f.pz);
            CAPTURE(f.ax);
            CAPTURE(f.ay);
            CAPTURE(f.az);
            CAPTURE(rho);
            if (excess < 0)
                CHECK(text == "accepted");
            else
                CHECK(text.find("cuts the base region") != std::string::npos);
            ++(excess < 0 ? clear : cut);
        }
    }
    CHECK(clear > 100);
    CHECK(cut == clear);
}

TEST_CASE("cylinders: parallel to the base and below it they are behind, tilted ones are met") {
    const PlaneBaseProblem problem =
        problem_of({Cylinder{{0, 0, -1}, {1, 0, 0}, 0.5}, Cylinder{{0, 5, -1}, {1, 0, 0}, 1},
                    Cylinder{{0, 5, -1}, {1, 0.5, 0x1p-40}, 0.5}, Cylinder{{0, 5, -1}, {1, 0, 0}, 1.5}});
    CHECK(problem.warnings ==
          std::vector<std::string>{
              "object 0, object 1: behind the base, never nearest to any point of its cell"});
    REQUIRE(problem.family.cylinders.size() == 2);
    for (const CylinderForm& f : problem.family.cylinders) CHECK(cylinder_height(f, 0.5, -0.5) > 0);
    CHECK(sites_of(problem, FormId{1}) == objects({2}));
    CHECK(sites_of(problem, FormId{2}) == objects({3}));
}

TEST_CASE("cylinders: the same cylinder in other words is merged, one ulp makes another") {
    const Cylinder pipe{{3.25, 0.5, 4}, {1, 0.5, 0.25}, 0.125};
    const Cylinder same{pipe.point - 4 * pipe.axis, -3 * pipe.axis, 0.125};
    Cylinder thicker = pipe, moved = pipe, turned = pipe;
    thicker.point.z() = 4.5;
    thicker.radius = std::nextafter(0.125, 1.0);
    moved.point.z() = std::nextafter(4.0, 5.0);
    turned.axis.y() = std::nextafter(0.5, 1.0);
    const PlaneBaseProblem problem = problem_of({pipe, moved, same, turned, thicker});
    REQUIRE(problem.family.cylinders.size() == 4);
    CHECK(sites_of(problem, FormId{1}) == objects({0, 2}));
    CHECK(problem.warnings ==
          std::vector<std::string>{
              "object 0 and object 2: the same distance from the base everywhere, merged"});
}

TEST_CASE("cylinders: what lies in a cylinder or beyond a wall is left out") {
    const auto above = [](double x) { return std::nextafter(x, 10.0); };
    const Cylinder outer{{0, 0, 1}, {1, 0, 0}, 0.5};
    PlaneBaseProblem problem =
        problem_of({Sphere{{0.25, 0, 1}, 0.5},                 // fills a stretch of it
                    outer, Sphere{{0.25, 0.25, 1}, 0.25},      // touches it from within
                    Cylinder{{5, 0.25, 1}, {-2, 0, 0}, 0.25},  // along a line
                    Sphere{{0.25, 0.25, 1}, above(0.25)}, Cylinder{{5, -0.25, 1}, {-2, 0, 0}, above(0.25)},
                    Cylinder{{5, 0.25, 1}, {-2, 0, 0x1p-60}, 0.125}});
    CHECK(problem.warnings == std::vector<std::string>{
                                  "object 0 in object 1, object 2 in object 1, object 3 in object 1: hidden, "
                                  "never nearest to any point of the cell"});
    REQUIRE(problem.sites.size() == 5);
    CHECK(sites_of(problem, FormId{0}) == objects({4}));
    CHECK(sites_of(problem, FormId{2}) == objects({1}));
    CHECK(sites_of(problem, FormId{3}) == objects({5}));
    CHECK(sites_of(problem, FormId{4}) == objects({6}));

    // Beyond a plane, touching it along a line; in it; the lid is half-way to a plane at z = 4.
    problem = problem_of({Plane{{0, 0, 1.5}, {0, 0.75, 1}}, Cylinder{{0, 0, 1.5 + 1.25}, {1, 0, 0}, 1},
                          Cylinder{{7, 0, 1.5}, {1, 0, 0}, 0}, Cylinder{{0, 3, 5}, {1, 0, 0}, 1},
                          Cylinder{{0, -3, 5}, {1, 0, 0}, above(1)},
                          Cylinder{{0, 0, 1.5 + 1.25}, {1, 0, 0}, above(1)}});
    CHECK(
        problem.warnings ==
        std::vector<std::string>{"object 1 beyond object 0, object 2 beyond object 0, object 3 beyond object "
                                 "0: hidden, never nearest to any point of the cell"});
    CHECK(problem.family.cylinders.size() == 2);
    // A ball in a cylinder that is left out itself.
    problem = problem_of(
        {Plane{{0, 0, 1.5}, {0, 0.75, 1}}, Cylinder{{0, 3, 5}, {1, 0, 0}, 1}, Sphere{{0, 3, 5}, 0.5}});
    CHECK(problem.warnings ==
          std::vector<std::string>{"object 1 beyond object 0, object 2 in object 1: hidden, never nearest to "
                                   "any point of the cell"});
    problem = problem_of({Cylinder{{0, 0, 5}, {1, 0, 0}, 1}, Cylinder{{0, 0, 5}, {1, 0, 0}, above(1)}});
    CHECK(problem.warnings ==
          std::vector<std::string>{
              "object 0 beyond side box:+z: hidden, never nearest to any point of the cell"});
}

TEST_CASE("cylinders: hidden objects never come nearer than what hides them") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 200; ++round) {
        const CylinderForm outer{unit(rng), unit(rng), 3 + unit(rng), unit(rng), unit(rng), unit(rng), 0.7};
        CylinderForm inner = outer;
        inner.px += 0.2 * unit(rng);
        inner.pz += 0.2 * unit(rng);
        inner.rho = 0.5 + 0.3 * unit(rng);
        const Real apart = distance(outer, inner.px, inner.py, inner.pz) + outer.rho;
        const bool inside = contains(outer, inner);
        CHECK(inside == (apart + inner.rho <= outer.rho));
        CHECK(contains(outer, inner.px, inner.py, inner.pz, inner.rho) == inside);
        if (!inside) continue;
        for (int k = 0; k < 10; ++k) {
            const double x = 5 * unit(rng), y = 5 * unit(rng), z = 5 * unit(rng);
            CHECK(distance(outer, x, y, z) <= distance(inner, x, y, z) + Real(1e-90));
        }
    }
}

TEST_CASE("cylinders: nearly touching or nearly parallel beyond doubles is out of range, not wrong") {
    CHECK(complaint({Cylinder{{0, 0, 1e-130}, {1, 0, 0}, 0}}).find("leaves the range of doubles") !=
          std::string::npos);
    CHECK(complaint({Cylinder{{0, 9, -1}, {1, 0, 1e-130}, 0}}).find("leaves the range of doubles") !=
          std::string::npos);
    CHECK(complaint({Cylinder{{0, 9, -1}, {1, 0, 1e-100}, 0}}) == "accepted");
}

}  // namespace vcell::plane_base_cylinder_test
