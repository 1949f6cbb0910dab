#include "../../primitives/bisectors/trisector.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "reference.hpp"
#include "test_support.hpp"

namespace vcell::trisector_test {
using Kind = TrisectorKind;

namespace {

struct Triple {
    Object base, a, b;
};

// Points of a line or conic within 10 of the origin: where random lines (of its plane) meet it.
std::vector<Vec3> sampled(const TrisectorComponent& c, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> wide(-10, 10);
    std::vector<Vec3> points;
    if (c.kind == Kind::Line) {
        for (int i = 0; i < 20; ++i) points.push_back(c.point + wide(rng) * c.direction);
        return points;
    }
    const Vec3 n = c.plane.head<3>(), e = n.unitOrthogonal(), f = n.cross(e);
    for (int i = 0; i < 400; ++i) {
        const Eigen::Vector4d p = Vec3(-c.plane(3) * n + wide(rng) * e + wide(rng) * f).homogeneous();
        Eigen::Vector4d q = Eigen::Vector4d::Zero();
        q.head<3>() = std::cos(wide(rng)) * e + std::sin(wide(rng)) * f;
        const double A = q.dot(c.quadric * q), B = p.dot(c.quadric * q), C = p.dot(c.quadric * p);
        if (B * B - A * C < 0) continue;
        const double t = -C / (B + std::copysign(std::sqrt(B * B - A * C), B));
        if (std::abs(t) < 10) points.push_back((p + t * q).head<3>());
    }
    return points;
}

// Samples are equally far from all three, or on a virtual branch; returns how many are real.
int check_points(const TrisectorComponent& c, const Triple& t, std::mt19937_64& rng, bool nested = false) {
    int real = 0;
    for (const Vec3& p : sampled(c, rng)) {
        double d[3] = {distance(t.base, p), distance(t.a, p), distance(t.b, p)};
        if (nested)
            for (double& x : d) x = std::abs(x);
        const double spread = std::max({d[0], d[1], d[2]}) - std::min({d[0], d[1], d[2]});
        if (c.clearance) {
            // Up to its sign all distances follow the clearance, on virtual branches too.
            const double r = c.clearance->dot(p.homogeneous());
            int followed = 0;
            for (const Object* o : {&t.base, &t.a, &t.b}) {
                double rho = 0;
                if (const auto* s = std::get_if<Sphere>(o)) rho = s->radius;
                if (const auto* y = std::get_if<Cylinder>(o)) rho = y->radius;
                const double centre = distance(*o, p) + rho;
                followed += std::abs(centre - std::abs(r + rho)) < 1e-9 ||
                            std::abs(centre - std::abs(rho - r)) < 1e-9;
            }
            CHECK(followed == 3);
        } else {
            CHECK(spread < 1e-9);
        }
        real += spread < 1e-9;
    }
    return real;
}

// "circle ellipse", in alphabetical order.
std::string kinds(const Trisector& t) {
    std::vector<std::string> names;
    for (const TrisectorComponent& c : t.components) names.emplace_back(to_string(c.kind));
    std::ranges::sort(names);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
    return text;
}

const Plane floor_plane{{0, 0, 0}, {0, 0, 1}};

double up(double x) { return std::nextafter(x, 100.0); }

}  // namespace

TEST_CASE("trisector: planes with anything, and three spheres, have lines and conics") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vec = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    const auto plane = [&] { return Plane{vec() + Vec3(0, 0, 2), vec()}; };
    const auto sphere = [&] { return Sphere{vec() + Vec3(0, 0, 2), 0.3 + 0.2 * unit(rng)}; };
    const auto cylinder = [&] { return Cylinder{vec() + Vec3(0, 0, 2), vec(), 0.3 + 0.2 * unit(rng)}; };
    int real = 0, components = 0;
    for (int round = 0; round < 40; ++round) {
        Cylinder along = cylinder();
        const Cylinder pipe = cylinder();
        along.axis = 4 * pipe.axis;
        for (const Triple& t : {Triple{floor_plane, plane(), plane()}, Triple{floor_plane, plane(), sphere()},
                                Triple{floor_plane, plane(), cylinder()}, Triple{plane(), sphere(), sphere()},
                                Triple{sphere(), sphere(), sphere()}, Triple{sphere(), plane(), sphere()},
                                Triple{cylinder(), plane(), plane()}, Triple{floor_plane, pipe, along}}) {
            const Trisector curve = trisector(t.base, t.a, t.b);
            for (const TrisectorComponent& c : curve.components) {
                REQUIRE(c.kind != Kind::Spline);
                CHECK(c.degree == (c.kind == Kind::Line ? 1 : 2));
                CHECK(c.clearance.has_value());
                // Paraboloids of spheres meet the slanted planes that bisect two planes in ellipses.
                if (c.kind == Kind::Circle) CHECK(std::abs(std::abs(c.plane(2)) - 1) < 1e-12);
                real += check_points(c, t, rng);
                ++components;
            }
        }
        CHECK(kinds(trisector(floor_plane, plane(), plane())) == "line line line line");
    }
    CHECK(components > 300);
    CHECK(real > 2000);
}

TEST_CASE("trisector: kinds of conics") {
    std::mt19937_64 rng(test_seed());
    const Sphere left{{-1, 0, 2}, 0.5}, right{{1, 0, 2}, 0.5}, high{{0, 0, 4}, 1};
    // Equal spheres over a plane: the upright plane between them, a parabola.
    CHECK(kinds(trisector(floor_plane, left, right)) == "parabola");
    CHECK(kinds(trisector(floor_plane, left, Sphere{{1, 0, 2}, up(0.5)})) == "ellipse");
    // One above the other: a circle, or none.
    CHECK(kinds(trisector(floor_plane, Sphere{{0, 0, 2}, 0.5}, high)) == "circle");
    CHECK(kinds(trisector(floor_plane, Sphere{{0, 0, 6}, 3}, high)) == "");
    CHECK(kinds(trisector(floor_plane, high, Plane{{0, 0, 7}, {0, 0, 1}})) == "circle");
    CHECK(kinds(trisector(floor_plane, high, Plane{{0, 0, 7}, {0, 1, 4}})) == "ellipse");
    // Three spheres: line, ellipse, hyperbola, circle.
    CHECK(kinds(trisector(left, right, Sphere{{0, 3, 2}, 0.5})) == "line");
    CHECK(kinds(trisector(left, right, Sphere{{0, 3, 2}, up(0.5)})) == "hyperbola");
    CHECK(kinds(trisector(Sphere{{-1, 0, 0}, 0.75}, Sphere{{1, 0, 0}, 0.75}, Sphere{{0, 0, 0}, 0.5})) ==
          "circle");
    CHECK(kinds(trisector(Sphere{{-1, 0, 0}, 0}, Sphere{{1, 0, 0}, 0}, Sphere{{0, 0, 0}, 0.5})) == "");
    // Cones of a plane and cylinders, cut by the plane half-way to a roof.
    const Cylinder upright{{0, 0, 0}, {0, 0, 1}, 0.5};
    CHECK(kinds(trisector(floor_plane, upright, Plane{{0, 0, 4}, {0, 0, 1}})) == "circle");
    CHECK(kinds(trisector(floor_plane, Cylinder{{0, 0, 0}, {1, 0, 1}, 0.5}, Plane{{0, 0, 4}, {0, 0, 1}})) ==
          "ellipse");
    CHECK(kinds(trisector(floor_plane, Cylinder{{0, 0, 2}, {1, 0, 0}, 0.5}, Plane{{0, 0, 4}, {0, 0, 1}})) ==
          "line line");
}

TEST_CASE("trisector: what is no conic is a spline of degree four or eight") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vec = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    const auto sphere = [&] { return Sphere{vec() + Vec3(0, 0, 2), 0.3 + 0.2 * unit(rng)}; };
    const auto cylinder = [&] { return Cylinder{vec() + Vec3(0, 0, 2), vec(), 0.3 + 0.2 * unit(rng)}; };
    for (int round = 0; round < 20; ++round) {
        for (const auto& [t, degree] : {std::pair{Triple{floor_plane, sphere(), cylinder()}, 4},
                                        {Triple{floor_plane, cylinder(), cylinder()}, 4},
                                        {Triple{sphere(), sphere(), cylinder()}, 4},
                                        {Triple{sphere(), cylinder(), cylinder()}, 8},
                                        {Triple{cylinder(), cylinder(), cylinder()}, 8}}) {
            const Trisector curve = trisector(t.base, t.a, t.b);
            CHECK(kinds(curve) == "spline");
            CHECK(curve.degree() == degree);
            CHECK_FALSE(curve.splits_irrationally);
        }
    }
}

TEST_CASE("trisector: special positions split, and no longer one ulp away") {
    std::mt19937_64 rng(test_seed());
    struct Case {
        std::string name;
        Triple special, near;
        std::string kinds;
        std::string near_kinds;
        int least_real;
        bool nested = false;
    };
    const Cylinder pipe{{0, 0, 3}, {3, 4, 0}, 0.5}, level{{0, 0, 3}, {0, 5, 0}, 0.5};
    const Cylinder upright{{7, 2, 0}, {0, 0, 1}, 0.5};
    const Cylinder x{{0, 0, 0}, {1, 0, 0}, 0.5}, y{{0, 0, 0}, {0, 2, 0}, 0.5}, z{{0, 0, 0}, {0, 0, 4}, 0.5};
    const std::vector<Case> cases = {
        {"plane, equal cylinders with crossing axes",
         {floor_plane, pipe, level},
         {floor_plane, pipe, Cylinder{level.point, level.axis, up(0.5)}},
         "parabola parabola",
         "spline",
         20},
        {"plane, equal tilted cylinders with crossing axes",
         {floor_plane, Cylinder{{0, 0, 9}, {2, 2, 1}, 0.5}, Cylinder{{0, 0, 9}, {6, 3, -2}, 0.5}},
         {floor_plane, Cylinder{{0, 0, 9}, {2, 2, 1}, 0.5}, Cylinder{{0, 0, up(9)}, {6, 3, -2}, 0.5}},
         "ellipse hyperbola",
         "spline",
         20},
        {"plane, parallel cylinders",
         {floor_plane, pipe, Cylinder{{2, 0, 3}, {-6, -8, 0}, 0.25}},
         {floor_plane, pipe, Cylinder{{2, 0, 3}, {-6, up(-8), 0}, 0.25}},
         "line line",
         "spline",
         10},
        {"plane, upright cylinder, ball on its axis",
         {floor_plane, upright, Sphere{{7, 2, 3}, 1}},
         {floor_plane, upright, Sphere{{7, up(2), 3}, 1}},
         "circle circle",
         "spline",
         20},
        {"three equal cylinders along the axes",
         {x, y, z},
         {x, y, Cylinder{z.point, z.axis, up(0.5)}},
         "line line line line",
         "spline spline",
         40},
        {"a point where two lines cross",
         {Sphere{{0, 0, 0}, 0}, Cylinder{x.point, x.axis, 0}, Cylinder{y.point, y.axis, 0}},
         {Sphere{{0, up(0), 0}, 0}, Cylinder{x.point, x.axis, 0}, Cylinder{y.point, y.axis, 0}},
         "line",
         "line line",
         20},
        {"equal ball and two cylinders with crossing axes",
         {Sphere{{1, 2, 3}, 0.5}, x, y},
         {Sphere{{1, 2, 3}, up(0.5)}, x, y},
         "parabola parabola",
         "spline spline",
         20},
        {"coaxial cylinders and a plane across",
         {x, Cylinder{{3, 0, 0}, {2, 0, 0}, 2}, Plane{{4, 0, 0}, {1, 0, 0}}},
         {x, Cylinder{{3, 0, up(0)}, {2, 0, 0}, 2}, Plane{{4, 0, 0}, {1, 0, 0}}},
         "circle",
         "ellipse",
         20,
         true},
        {"three parallel cylinders",
         {x, Cylinder{{0, 3, 0}, {2, 0, 0}, 1}, Cylinder{{0, 0, 4}, {-1, 0, 0}, 0.25}},
         {x, Cylinder{{0, 3, 0}, {2, 0, 0}, 1}, Cylinder{{0, 0, 4}, {-1, 0, 1e-17}, 0.25}},
         "line",
         "spline",
         10},
        {"coaxial cylinders and a ball on their axis",
         {x, Cylinder{{3, 0, 0}, {2, 0, 0}, 2}, Sphere{{1, 0, 0}, 2.5}},
         {x, Cylinder{{3, 0, 0}, {2, 0, 0}, 2}, Sphere{{1, up(0), 0}, 2.5}},
         "circle circle",
         "spline",
         20,
         true},
    };
    for (const Case& c : cases) {
        CAPTURE(c.name);
        const Trisector curve = trisector(c.special.base, c.special.a, c.special.b);
        CHECK(kinds(curve) == c.kinds);
        CHECK_FALSE(curve.splits_irrationally);
        int real = 0;
        for (const TrisectorComponent& part : curve.components)
            if (part.kind != Kind::Spline) real += check_points(part, c.special, rng, c.nested);
        CHECK(real >= c.least_real);
        CHECK(kinds(trisector(c.near.base, c.near.a, c.near.b)) == c.near_kinds);
    }
}

TEST_CASE("trisector: planes with irrational coefficients leave the whole curve a spline, and say so") {
    const Cylinder pipe{{0, 0, 3}, {1, 1, 0}, 0.5}, level{{0, 0, 3}, {1, 0, 0}, 0.5};
    const Trisector curve = trisector(floor_plane, pipe, level);
    CHECK(kinds(curve) == "spline");
    CHECK(curve.splits_irrationally);
    CHECK(curve.degree() == 4);
}

TEST_CASE("trisector: arcs of conics are exact rational quadratics") {
    std::mt19937_64 rng(test_seed());
    const Sphere high{{0, 0, 4}, 1};
    int arcs = 0;
    for (const Triple& t : {Triple{floor_plane, high, Plane{{0, 0, 7}, {0, 1, 4}}},
                            Triple{floor_plane, Sphere{{-1, 0, 2}, 0.5}, Sphere{{1, 0, 2}, 0.5}},
                            Triple{Sphere{{-1, 0, 2}, 0.5}, Sphere{{1, 0, 2}, 0.5}, Sphere{{0, 3, 2}, 0.75}},
                            Triple{floor_plane, Plane{{0, 0, 4}, {0, 1, 2}}, Plane{{0, 3, 0}, {1, 2, 0}}}})
        for (const TrisectorComponent& c : trisector(t.base, t.a, t.b).components) {
            const std::vector<Vec3> points = sampled(c, rng);
            REQUIRE(points.size() > 2);
            for (std::size_t i = 0; i + 1 < points.size(); ++i) {
                const auto arc = trisector_arc(c, points[i], points[i + 1]);
                if (!arc) continue;
                ++arcs;
                CHECK(arc->degree == (c.kind == Kind::Line ? 1 : 2));
                CHECK((arc->evaluate(0) - points[i]).norm() < 1e-12);
                CHECK((arc->evaluate(1) - points[i + 1]).norm() < 1e-12);
                for (const double s : {0.25, 0.5, 0.75}) {
                    const Eigen::Vector4d p = arc->evaluate(s).homogeneous();
                    CHECK(std::abs(c.plane.dot(p)) < 1e-8);
                    CHECK(std::abs(p.dot(c.quadric * p)) <= 1e-8 * c.quadric.norm() * p.squaredNorm());
                }
            }
        }
    CHECK(arcs > 100);
}

}  // namespace vcell::trisector_test
