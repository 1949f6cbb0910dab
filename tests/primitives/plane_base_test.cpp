#include "../../primitives/bases/plane_base.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "../../core/errors.hpp"
#include "problem_sites.hpp"
#include "reference.hpp"
#include "test_support.hpp"

namespace vcell::plane_base_test {
using Kind = InputError::Kind;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

// The square [-1,1]^2 under a lid at z = 2.
Scene square_scene(std::vector<Object> objects = {}) {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = std::move(objects);
    scene.box = {{-1, -1, 0}, {1, 1, 2}};
    return scene;
}

InputError error_of(const Scene& scene) {
    validate(scene);
    try {
        plane_base_problem(scene);
    } catch (const InputError& error) {
        return error;
    }
    FAIL("the scene was accepted");
    std::abort();
}

// Distance of a canonical point from an object in canonical coordinates, 100 digits.
Real distance(const Object& object, const BaseFrame& frame, const std::array<Real, 3>& p) {
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const Vec3 c = frame.to_canonical(sphere->center);
        Real square = 0;
        for (int i = 0; i < 3; ++i) square += (p[i] - c[i]) * (p[i] - c[i]);
        return sqrt(square) - sphere->radius;
    }
    const auto& plane = std::get<Plane>(object);
    const Vec3 q = frame.to_canonical(plane.point), n = frame.rotation * plane.normal;
    Real value = 0, square = 0;
    for (int i = 0; i < 3; ++i) {
        value += Real(n[i]) * (p[i] - q[i]);
        square += Real(n[i]) * n[i];
    }
    return abs(value) / sqrt(square);
}

double box_excess(const Box& box, const Vec3& p) {
    return std::max((box.min - p).maxCoeff(), (p - box.max).maxCoeff());
}

std::vector<double> fields(const CircularForm& f) { return {f.k, f.cx, f.cy, f.a, f.b, f.e, f.w}; }

}  // namespace

TEST_CASE("frame: axis-parallel normals are signed permutations and keep digits") {
    const Vec3 p(0.1, -0.7, 0.3);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
            Scene scene = square_scene();
            scene.base = Plane{{0.5, 0.5, 0.5}, 3 * sign * Vec3::Unit(axis)};
            scene.box = {{-1, -1, -1}, {1, 1, 1}};
            const BaseFrame frame = plane_base_problem(scene).frame;
            CAPTURE(axis);
            CHECK(frame.rotation.determinant() == 1);
            CHECK(frame.rotation.row(2) == sign * Vec3::Unit(axis).transpose());
            CHECK(frame.rotation.cwiseAbs().sum() == 3);
            const Vec3 c = frame.to_canonical(p);
            CHECK(c.z() == sign * (p[axis] - 0.5));
            CHECK(std::abs(c.x()) == std::abs(p[(axis + (sign > 0 ? 1 : 2)) % 3]));
            CHECK(frame.to_canonical({0.5, 0.5, 0.5}).z() == 0);
        }
    }
}

TEST_CASE("frame: oblique normals give a rotation onto the base") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    for (int i = 0; i < 200; ++i) {
        Scene scene = square_scene();
        const Vec3 n = Vec3(normal(rng), normal(rng), normal(rng)) * std::exp(20 * normal(rng));
        const Vec3 point(0.1 * normal(rng), 0.1 * normal(rng), 0.1 * normal(rng));
        scene.base = Plane{point, n};
        scene.box = {{-1, -1, -1}, {1, 1, 1}};
        const BaseFrame frame = plane_base_problem(scene).frame;
        CHECK((frame.rotation * frame.rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 8 * u);
        CHECK(frame.rotation.determinant() > 0);
        CHECK((frame.rotation * n.normalized() - Vec3::UnitZ()).norm() < 8 * u);
        CHECK(std::abs(frame.to_canonical(point).z()) < 8 * u);
    }
}

TEST_CASE("region: a box standing on the base is its own floor, exactly") {
    const PlaneBaseProblem problem = plane_base_problem(square_scene());
    REQUIRE(problem.region.size() == 4);
    const std::vector<std::array<double, 4>> expected = {
        {0, 1, 1, 2}, {-1, 0, 1, 1}, {0, -1, 1, 3}, {1, 0, 1, 0}};
    for (int i = 0; i < 4; ++i) {
        const RegionSide& side = problem.region[i];
        CHECK(std::array{side.a, side.b, side.c, double(side.site.index)} == expected[i]);
    }
    CHECK(problem.corners[0] == Eigen::Vector2d(-1, -1));
    CHECK(problem.corners[2] == Eigen::Vector2d(1, 1));
    CHECK(region_area(problem.region) == 4);
    // The lid is the only side above the base.
    REQUIRE(problem.family.forms.size() == 1);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::box_side(5)});
    CHECK(problem.family.forms[FormId{0}](0.3, 0.4) == 2);
}

TEST_CASE("region: the plane across a cube's diagonal cuts a hexagon") {
    Scene scene = square_scene();
    scene.base = Plane{{0, 0, 0}, {1, 1, 1}};
    scene.box = {{-1, -1, -1}, {1, 1, 1}};
    const PlaneBaseProblem problem = plane_base_problem(scene);
    CHECK(problem.region.size() == 6);
    CHECK(region_area(problem.region) == doctest::Approx(3 * std::sqrt(3.0)).epsilon(1e-15));
    // Three sides lean over the base.
    CHECK(problem.family.forms.size() == 3);
}

TEST_CASE("region: of tilted planes it is convex, in the box, and on the sides it names") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    std::uniform_int_distribution<int> coin(0, 2);
    for (int round = 0; round < 300; ++round) {
        Scene scene = square_scene();
        Vec3 n(normal(rng), normal(rng), normal(rng));
        if (coin(rng) == 0) n[coin(rng)] = 0;  // parallel to an axis
        if (n.norm() == 0) continue;
        scene.base = Plane{{0.3 * normal(rng), 0.3 * normal(rng), 0.3 * normal(rng)}, n};
        scene.box = {{-1, -2, -1.5}, {1, 1, 2}};
        PlaneBaseProblem problem;
        try {
            problem = plane_base_problem(scene);
        } catch (const InputError&) {
            continue;
        }
        const std::size_t count = problem.region.size();
        REQUIRE(count >= 3);
        double shoelace = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Eigen::Vector2d p = problem.corners[i], q = problem.corners[(i + 1) % count];
            shoelace += 0.5 * (p.x() * q.y() - p.y() * q.x());
            const RegionSide& side = problem.region[i];
            CHECK(std::abs(side.a * p.x() + side.b * p.y() + side.c) < 32 * u);
            CHECK(std::abs(side.a * q.x() + side.b * q.y() + side.c) < 32 * u);
            const Vec3 world = problem.frame.to_world({p.x(), p.y(), 0});
            CHECK(std::abs(box_excess(scene.box, world)) < 32 * u);
            const std::uint32_t s = side.site.index;
            CHECK(world[s / 2] ==
                  doctest::Approx((s % 2 ? scene.box.max : scene.box.min)[s / 2]).epsilon(1e-14));
        }
        CHECK(region_area(problem.region) == doctest::Approx(shoelace).epsilon(1e-13));
        for (std::size_t i = 0; i < count; ++i) {
            const RegionSide &s = problem.region[i], &t = problem.region[(i + 1) % count];
            CHECK((Exact(s.a) * t.b - Exact(s.b) * t.a).sign() == Sign::Positive);
        }
    }
}

TEST_CASE("region: a side of the box that the base meets in a corner alone bounds nothing") {
    // By integers: where the base cuts edges of the box, which are so many corners of the region, once each.
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> place(0, 4), part(-2, 2);
    int with_corners = 0;
    for (int round = 0; round < 400 * rounds(); ++round) {
        const Eigen::Vector3i normal(part(rng), part(rng), part(rng)),
            point(place(rng), place(rng), place(rng));
        Scene scene;
        scene.base = Plane{point.cast<double>(), normal.cast<double>()};
        scene.box = {Vec3::Zero(), {4, 3, 2}};
        const Eigen::Vector3i size(4, 3, 2);
        const auto height = [&](unsigned corner) {
            int sum = 0;
            for (int k = 0; k < 3; ++k)
                sum += normal[k] * (((corner >> k & 1u) != 0 ? size[k] : 0) - point[k]);
            return sum;
        };
        int crossed = 0, on_base = 0, above = 0, below = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            on_base += height(corner) == 0;
            above += height(corner) > 0;
            below += height(corner) < 0;
            for (unsigned k = 0; k < 3; ++k)
                crossed += (corner >> k & 1u) == 0 && height(corner) * height(corner | 1u << k) < 0;
        }
        if (above == 0 || below == 0) continue;
        const PlaneBaseProblem problem = plane_base_problem(scene);
        CAPTURE(normal.transpose());
        CAPTURE(point.transpose());
        REQUIRE(problem.region.size() == static_cast<std::size_t>(crossed + on_base));
        for (std::size_t i = 0; i < problem.corners.size(); ++i)
            CHECK((problem.corners[i] - problem.corners[(i + 1) % problem.corners.size()]).norm() *
                      problem.unit >
                  0.1);
        with_corners += on_base > 0;
    }
    CHECK(with_corners > 50 * rounds());
}

TEST_CASE("region: a base plane without room in the box is an error that names both") {
    const auto with_base = [](const Vec3& point, const Vec3& normal) {
        Scene scene = square_scene();
        scene.base = Plane{point, normal};
        return error_of(scene);
    };
    const Vec3 up(0, 0, 1);
    for (const InputError& error :
         {with_base({0, 0, 3}, up), with_base({0, 0, 2}, up), with_base({0, 0, 0}, -up),
          with_base({0, 0, -1}, up), with_base({1, 1, 0}, {1, 1, 0}), with_base({1, 1, 2}, {1, 1, 1}),
          with_base({9, 0, 0}, {1, 0.5, 0.25})}) {
        CHECK(error.kind == Kind::EmptyBox);
        CHECK(error.path == "box");
        CHECK(std::string(error.what()).find("base.plane") != std::string::npos);
    }
    // The box's top as a base that looks down, and its bottom that looks up, are fine.
    Scene scene = square_scene();
    scene.base = Plane{{0, 0, 2}, -up};
    CHECK(plane_base_problem(scene).region.size() == 4);
}

TEST_CASE("heights: the bisector's point is equally far from base and object") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 200; ++round) {
        Scene scene = square_scene();
        scene.box = {{-1, -1, -1}, {1, 1, 2}};
        if (round % 2) scene.base = Plane{{0, 0, 0}, {0.3 * unit(rng), 0.3 * unit(rng), 1}};
        scene.objects = {Sphere{{unit(rng), unit(rng), 1.8 + 0.2 * unit(rng)}, 0.3 + 0.3 * unit(rng)},
                         Plane{{0, 0, 1.5}, {0.3 * unit(rng), 0.3 * unit(rng), unit(rng) > 0 ? 1.0 : -2.0}},
                         Plane{{0, 0, -3}, {0.3 * unit(rng), 0.3 * unit(rng), unit(rng) > 0 ? 1.0 : -2.0}}};
        PlaneBaseProblem problem;
        try {
            problem = plane_base_problem(scene);
        } catch (const InputError&) {
            continue;  // the ceiling came down to the base in a corner
        }
        for (const FormId f : problem.family.forms.ids()) {
            const Site site = problem.sites[f].front();
            if (!site.is_object()) continue;
            const ExactForm form = problem.family.exact(f);
            const double x = 0.5 * unit(rng), y = 0.5 * unit(rng);
            const Real t = (real(form.K) * (Real(x) * x + Real(y) * y) + real(form.A) * x + real(form.B) * y +
                            real(form.C)) /
                           real(form.W);
            const Real d = distance(scene.objects[site.index], problem.frame, {x, y, t});
            CAPTURE(site.index);
            // Exact for spheres, where doubles hold the canonical centre; a plane's |n| has been rounded
            // once.
            const bool is_exact = site.index == 0 && problem.frame.is_axis_parallel();
            CHECK(abs(d - t) <= (is_exact ? Real(1e-80) : 16 * u * (1 + t)));
            CHECK(problem.family.forms[f](x, y) == doctest::Approx(t.convert_to<double>()).epsilon(1e-13));
        }
    }
}

TEST_CASE("frame: a tilted plane leaves alone what objects are to each other") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const Vec3& normal : {Vec3(2, 3, 6), Vec3(0.1, -0.2, 0.9), Vec3(1e-17, 0, 1), Vec3(1, 1, 1)}) {
        CAPTURE(normal.transpose());
        Scene scene = square_scene();
        scene.box = {{-1, -1, -1}, {1, 1, 1}};
        scene.base = Plane{{0.1, 0.2, -0.05}, normal};
        for (int i = 0; i < 5; ++i)
            scene.objects.push_back(
                Sphere{4 * normal.normalized() + Vec3(unit(rng), unit(rng), unit(rng)), 0.1 + 0.1 * i});
        const PlaneBaseProblem problem = plane_base_problem(scene);
        struct Center {
            Real x, y, z;
        };
        std::vector<Center> centers;
        for (std::uint32_t i = 0; i < 5; ++i) {
            const FormId f{i};
            REQUIRE(sites_of(problem, f) == std::vector{Site::object(i)});
            const ExactForm e = problem.family.exact(f);
            const Real K = real(e.K);
            // w = 2 (z + rho) over K.
            centers.push_back({-real(e.A) / (2 * K), -real(e.B) / (2 * K),
                               real(e.W) / (2 * K) - std::get<Sphere>(scene.objects[i]).radius});
            for (std::uint32_t j = 0; j < i; ++j) {
                const Vec3 &p = std::get<Sphere>(scene.objects[i]).center,
                           &q = std::get<Sphere>(scene.objects[j]).center;
                Real world = 0;
                for (int k = 0; k < 3; ++k) world += (Real(p[k]) - q[k]) * (Real(p[k]) - q[k]);
                const Real x = centers[i].x - centers[j].x, y = centers[i].y - centers[j].y,
                           z = centers[i].z - centers[j].z;
                CHECK(abs(x * x + y * y + z * z - world) <= Real(1e-80));
            }
            // And the doubles stand for that.
            const CircularForm& c = problem.family.forms[f];
            const Real value = (real(e.K) * (Real(0.25) * 0.25 + Real(0.5) * 0.5) + real(e.A) * 0.25 +
                                real(e.B) * 0.5 + real(e.C)) /
                               real(e.W);
            CHECK(c(0.25, 0.5) == doctest::Approx(value.convert_to<double>()).epsilon(1e-14));
        }
        CHECK((problem.moves.all == 0) == false);  // sides of the box
        CHECK(problem.moves.all <= 0x1p-46);
    }
    // A normal of length 7 leaves the base where it is, and axis-parallel ones the box.
    CHECK(plane_base_problem(square_scene()).moves.all == 0);
}

TEST_CASE("forms: double fields are within 4u of the exact ones") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 300; ++round) {
        Scene scene = square_scene();
        // Tiny gaps and tilts make every sum and difference in the formulas cancel.
        const double tiny = std::ldexp(unit(rng), -static_cast<int>(rng() % 40));
        scene.objects = {Sphere{{unit(rng), unit(rng), 0.7}, 0.7 - 0.7 * std::abs(tiny)},
                         Sphere{{4.0, unit(rng), tiny}, 1.0},
                         Sphere{{4.0, unit(rng), -1 + std::abs(tiny)}, 1.0},
                         Plane{{0, 0, -3}, {tiny, unit(rng) * tiny, 1}},
                         Plane{{0, 0, 3}, {0.1 * tiny, unit(rng) * tiny, 0.7}}};
        scene.box.max.z() = 3;
        const PlaneBaseProblem problem = plane_base_problem(scene);
        for (const FormId f : problem.family.forms.ids()) {
            const CircularForm& form = problem.family.forms[f];
            const ExactForm exact = problem.family.exact(f);
            const auto close = [](const Exact& value, double rounded) {
                const Real v = real(value);
                return abs(v - rounded) <= 4 * u * abs(v);
            };
            const Exact cx(form.cx), cy(form.cy);
            CHECK(close(exact.W, form.w));
            CHECK(exact.W.sign() == Sign::Positive);
            CHECK(exact.K == Exact(form.k));
            if (form.k == 0) {
                CHECK(close(exact.A, form.a));
                CHECK(close(exact.B, form.b));
                CHECK(close(exact.C, form.e));
            } else {
                CHECK(close(exact.C - cx * cx - cy * cy, form.e));
                CHECK(exact.A == -2.0 * cx);
                CHECK(exact.B == -2.0 * cy);
            }
        }
    }
}

TEST_CASE("objects against the region: touching is exact to the last bit") {
    const auto below = [](double x) { return std::nextafter(x, 0.0); };
    // Clear of the base, touching it, cutting it.
    CHECK_NOTHROW(plane_base_problem(square_scene({Sphere{{0, 0, 1}, below(1)}})));
    InputError error = error_of(square_scene({Sphere{{0, 0, 1.5}, 0.1}, Sphere{{0.25, 0.5, 1}, 1}}));
    CHECK(error.kind == Kind::TouchesBase);
    CHECK(error.object == 1);
    CHECK(std::string(error.what()) == "objects[1].sphere: touches the base region at (0.25, 0.5, 0)");
    error = error_of(square_scene({Sphere{{0.25, 0.5, -0.5}, 1}}));
    CHECK(std::string(error.what()) == "objects[0].sphere: cuts the base region at (0.25, 0.5, 0)");
    CHECK(error_of(square_scene({Sphere{{0.5, 0.5, 0}, 0}})).kind == Kind::TouchesBase);

    // Around a corner (3-4-5) and along a side, the sphere's centre on the base plane.
    error = error_of(square_scene({Sphere{{4, 5, 0}, 5}}));
    CHECK(std::string(error.what()) == "objects[0].sphere: touches the base region at (1, 1, 0)");
    CHECK_NOTHROW(plane_base_problem(square_scene({Sphere{{4, 5, 0}, below(5)}})));
    error = error_of(square_scene({Sphere{{-3, 0.5, 0}, 2}}));
    CHECK(std::string(error.what()) == "objects[0].sphere: touches the base region at (-1, 0.5, 0)");
    CHECK_NOTHROW(plane_base_problem(square_scene({Sphere{{-3, 0.5, 0}, below(2)}})));
    // 3-4-5 again, between centre height and the disk in the base plane; the far case is legal and nearest.
    CHECK(error_of(square_scene({Sphere{{5, 0, 3}, 5}})).kind == Kind::TouchesBase);
    const PlaneBaseProblem legal = plane_base_problem(square_scene({Sphere{{5, 0, 3}, below(5)}}));
    CHECK(legal.warnings.empty());
    CHECK(legal.family.forms[FormId{0}](0.5, 0.5) > 0);

    // Planes: through a corner, across, beyond the region, coincident.
    error = error_of(square_scene({Plane{{1, 1, 0}, {1, 1, 1}}}));
    CHECK(std::string(error.what()) == "objects[0].plane: touches the base region at (1, 1, 0)");
    error = error_of(square_scene({Plane{{0.5, 0, 0}, {1, 0, 1}}}));
    CHECK(std::string(error.what()) == "objects[0].plane: cuts the base region at (0.5, -1, 0)");
    CHECK(error_of(square_scene({Plane{{0, 0, 0}, {0, 0, 5}}})).kind == Kind::TouchesBase);
    CHECK_NOTHROW(plane_base_problem(square_scene({Plane{{std::nextafter(2.0, 3.0), 0, 0}, {1, 1, 1}}})));
}

TEST_CASE("objects behind the base are left out with a warning") {
    const PlaneBaseProblem problem =
        plane_base_problem(square_scene({Sphere{{0, 0, -2}, 1}, Sphere{{0, 0, 1}, 0.5}, Sphere{{3, 3, -1}, 1},
                                         Plane{{0, 0, -1}, {0, 0, -3}}, Plane{{0, 0, -1}, {0.1, 0, 1}}}));
    CHECK(problem.warnings ==
          std::vector<std::string>{
              "object 0, object 2, object 3: behind the base, never nearest to any point of its cell"});
    // The tilted plane behind the base still bends up into view.
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(1)});
    CHECK(sites_of(problem, FormId{1}) == std::vector{Site::object(4)});
    CHECK(sites_of(problem, FormId{2}) == std::vector{Site::box_side(5)});
}

TEST_CASE("duplicates: equal heights are one form with all their sites") {
    const Sphere ball{{0.25, 0, 1}, 0.5};
    const Plane wall{{1.5, 0, 0}, {0.375, 0.125, -0.25}};
    Scene scene = square_scene({ball, Plane{{0, 0, 4}, {0, 0, 3}}, wall, Sphere{{0.25, -0.0, 1}, 0.5},
                                Plane{wall.point, -3 * wall.normal}, ball, Sphere{{0.25, 0, 1}, 0.25}});
    scene.names = {"", "", "", "twin", "", "", ""};
    const PlaneBaseProblem problem = plane_base_problem(scene);
    const auto objects = [](std::vector<std::uint32_t> ids) {
        std::vector<Site> sites;
        for (const std::uint32_t i : ids) sites.push_back(Site::object(i));
        return sites;
    };
    REQUIRE(problem.sites.size() == 4);
    CHECK(sites_of(problem, FormId{0}) == objects({0, 3, 5}));
    // A plane at twice the lid's height has its bisector in the lid.
    CHECK(sites_of(problem, FormId{1}) == std::vector{Site::object(1), Site::box_side(5)});
    CHECK(sites_of(problem, FormId{2}) == objects({2, 4}));
    CHECK(sites_of(problem, FormId{3}) == objects({6}));
    REQUIRE(problem.warnings.size() == 3);
    CHECK(problem.warnings[0] ==
          "object 0 and object 3 (twin) and object 5: the same distance from the base everywhere, merged");
    CHECK(problem.warnings[1] ==
          "object 1 and side box:+z: the same distance from the base everywhere, merged");
}

TEST_CASE("duplicates: a hundred thousand spheres, each twice, take linear work") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    Scene scene = square_scene();
    for (int i = 0; i < 100'000; ++i) scene.objects.push_back(Sphere{{unit(rng), unit(rng), 1}, 0.001});
    for (int i = 0; i < 100'000; ++i) scene.objects.push_back(scene.objects[99'999 - i]);
    const PlaneBaseProblem problem = plane_base_problem(scene);
    CHECK(problem.family.forms.size() == 100'001);
    for (const std::uint32_t i : {0u, 1u, 99'999u})
        CHECK(sites_of(problem, FormId{i}) == std::vector{Site::object(i), Site::object(199'999 - i)});
}

TEST_CASE("what this version does not compute is an error with its path") {
    Scene scene = square_scene();
    scene.base = Sphere{{0, 0, 1}, 0.1};
    CHECK(error_of(scene).kind == Kind::Unsupported);
    CHECK(error_of(scene).path == "base.sphere");
    scene.base = Cylinder{{0, 0, 1}, {1, 0, 0}, 0.1};
    CHECK(error_of(scene).path == "base.cylinder");
}

TEST_CASE("an object too close to the base for doubles is out of range, not wrong") {
    const InputError error = error_of(square_scene({Sphere{{0, 0, 1e-200}, 0}}));
    CHECK(error.kind == Kind::OutOfRange);
    CHECK(error.path == "objects[0].sphere");
}

TEST_CASE("scaling by powers of two scales every form's heights exactly") {
    const auto scaled = [](double s) {
        Scene scene = square_scene(
            {Sphere{{0.3 * s, -0.2 * s, 1.1 * s}, 0.4 * s}, Plane{{0, 0, 1.7 * s}, {0.1, 0.2, 1}}});
        scene.box = {{-s, -s, 0}, {s, s, 2 * s}};
        return plane_base_problem(scene);
    };
    const PlaneBaseProblem one = scaled(1), large = scaled(0x1p60);
    REQUIRE(one.family.forms.size() == large.family.forms.size());
    for (const FormId f : one.family.forms.ids()) {
        CHECK(0x1p60 * one.family.forms[f](0.25, 0.5) == large.family.forms[f](0x1p58, 0x1p59));
        CHECK(fields(one.family.forms[f])[3] == fields(large.family.forms[f])[3]);
    }
}

}  // namespace vcell::plane_base_test
