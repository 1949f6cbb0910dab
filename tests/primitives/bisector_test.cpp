#include "../../primitives/bisectors/bisector.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <utility>

#include "../../core/errors.hpp"
#include "reference.hpp"
#include "test_support.hpp"

namespace vcell::bisector_test {
using Kind = BisectorKind;

namespace {

// |f(p)| over the sum of its terms' magnitudes.
double residual(const Polynomial3& f, const Vec3& p) {
    double sum = 0;
    for (const auto& [e, c] : f.terms())
        sum += std::abs(c.enclosure().mid() * std::pow(p.x(), e[0]) * std::pow(p.y(), e[1]) *
                        std::pow(p.z(), e[2]));
    return std::abs(f(ExactVector(p)).enclosure().mid()) / sum;
}

struct Expected {
    Kind kind;
    int degree;
    std::array<int, 2> patch;
};

// Points sampled on the patch over the rectangle are equally far from both and on the polynomial; how many.
int check_patch(const Object& base, const Object& a, const std::array<double, 2>& u,
                const std::array<double, 2>& v, bool nested = false, int sheet = 0) {
    const Bisector b = bisector(base, a);
    const auto patch = bisector_patch(base, a, u, v, sheet);
    if (!patch) return 0;
    CHECK(std::array{patch->degree_u, patch->degree_v} == b.patch_degree);
    int checked = 0;
    for (int i = 0; i <= 6; ++i)
        for (int j = 0; j <= 6; ++j) {
            const Vec3 p = patch->evaluate(u[0] + i * (u[1] - u[0]) / 6, v[0] + j * (v[1] - v[0]) / 6);
            if (p.norm() > 1e3) continue;  // towards infinity
            double d = distance(base, p), e = distance(a, p);
            if (nested) {
                d = std::abs(d);
                e = std::abs(e);
            }
            CHECK(residual(b.polynomial, p) < 1e-11);
            // Where the first branch ends the formula goes on with the sum of the distances.
            if (std::abs(d - e) > 1e-6) continue;
            CHECK(std::abs(d - e) < 1e-11 * (1 + p.norm()));
            ++checked;
        }
    return checked;
}

void check(const char* name, const Object& base, const Object& a, const Expected& expected) {
    CAPTURE(name);
    for (const Bisector& b : {bisector(base, a), bisector(a, base)}) {
        CHECK(to_string(b.kind) == to_string(expected.kind));
        CHECK(b.degree() == expected.degree);
        CHECK(b.patch_degree == expected.patch);
    }
}

}  // namespace

TEST_CASE("bisector: every pair has its name, degree and patch degrees, special positions too") {
    const Plane floor{{0, 0, 0}, {0, 0, 1}}, roof{{0, 0, 3}, {0, 3, -4}};
    const Sphere ball{{0.25, 0, 2}, 0.5};
    const Cylinder pipe{{0, 0, 2}, {1, 0.5, 0.25}, 0.5}, level{{0, 0, 2}, {1, 0.5, 0}, 0.5},
        upright{{3, 0, 0}, {0, 0, 2}, 0.5};
    check("planes", floor, roof, {Kind::PairOfPlanes, 2, {1, 1}});
    check("parallel planes", floor, Plane{{1, 2, 3}, {0, 0, -7}}, {Kind::Plane, 1, {1, 1}});
    check("plane, ball", floor, ball, {Kind::Paraboloid, 2, {2, 2}});
    check("plane, cylinder", floor, pipe, {Kind::EllipticCone, 2, {2, 1}});
    check("plane, cylinder along it", floor, level, {Kind::ParabolicCylinder, 2, {2, 1}});
    check("plane, cylinder across it", floor, upright, {Kind::CircularCone, 2, {2, 1}});
    check("line in the plane", floor, Cylinder{{1, 2, 0}, {1, 1, 0}, 0}, {Kind::Plane, 1, {1, 1}});
    check("balls", Sphere{{0, 0, 0}, 1}, Sphere{{1, 2, 3}, 0.5}, {Kind::Hyperboloid, 2, {2, 2}});
    check("equal balls", Sphere{{0, 0, 0}, 1}, Sphere{{1, 2, 3}, 1}, {Kind::Plane, 1, {1, 1}});
    check("ball in a ball", Sphere{{0, 0, 0}, 3}, Sphere{{1, 0, 1}, 0.5}, {Kind::Ellipsoid, 2, {2, 2}});
    check("concentric balls", Sphere{{1, 0, 1}, 3}, Sphere{{1, 0, 1}, 0.5}, {Kind::Sphere, 2, {2, 2}});
    check("ball, cylinder", Sphere{{0, 0, 5}, 1}, pipe, {Kind::Quartic, 4, {2, 2}});
    check("ball, equal cylinder", Sphere{{0, 0, 5}, 0.5}, pipe, {Kind::ParabolicCylinder, 2, {2, 2}});
    check("point on a line", Sphere{{2, 1, 2.5}, 0}, Cylinder{{0, 0, 2}, {1, 0.5, 0.25}, 0},
          {Kind::Plane, 1, {1, 1}});
    check("skew cylinders", pipe, Cylinder{{1, 0, 5}, {0, 1, 1}, 1}, {Kind::Quartic, 4, {2, 2}});
    check("crossing cylinders", pipe, Cylinder{{0, 0, 2}, {0, 1, 1}, 1}, {Kind::Quartic, 4, {2, 2}});
    check("equal skew cylinders", pipe, Cylinder{{1, 0, 5}, {0, 1, 1}, 0.5},
          {Kind::HyperbolicParaboloid, 2, {2, 2}});
    check("equal crossing cylinders", pipe, Cylinder{{0, 0, 2}, {0, 1, 1}, 0.5},
          {Kind::PairOfPlanes, 2, {1, 1}});
    check("parallel cylinders", pipe, Cylinder{{0, 0, 5}, {-2, -1, -0.5}, 1},
          {Kind::HyperbolicCylinder, 2, {2, 1}});
    check("equal parallel cylinders", pipe, Cylinder{{0, 0, 5}, {2, 1, 0.5}, 0.5}, {Kind::Plane, 1, {1, 1}});
    check("cylinder in a cylinder", pipe, Cylinder{{0, 0.25, 2}, {2, 1, 0.5}, 2},
          {Kind::EllipticCylinder, 2, {2, 1}});
    check("coaxial cylinders", pipe, Cylinder{{2, 1, 2.5}, {2, 1, 0.5}, 2},
          {Kind::CircularCylinder, 2, {2, 1}});
    check("line on a cylinder", Cylinder{{0, 0, 0}, {0, 0, 1}, 1}, Cylinder{{0, 1, 0}, {0, 0, 1}, 0},
          {Kind::Plane, 1, {1, 1}});

    for (const Object& o : std::vector<Object>{floor, ball, pipe})
        CHECK(bisector(o, o).kind == Kind::Everywhere);
    CHECK(bisector(floor, Plane{{4, 5, 0}, {0, 0, -2}}).kind == Kind::Everywhere);
    CHECK(bisector(pipe, Cylinder{{2, 1, 2.5}, {-4, -2, -1}, 0.5}).kind == Kind::Everywhere);
    CHECK(bisector(floor, Sphere{{0, 0, -2}, 1}).kind == Kind::Nowhere);
    CHECK(bisector(floor, Sphere{{0, 0, -1}, 1}).kind == Kind::Line);
    CHECK(bisector(Sphere{{0, 0, -1}, 1}, floor).kind == Kind::Paraboloid);
    CHECK(bisector(floor, Cylinder{{0, 0, -2}, {1, 0, 0}, 1}).kind == Kind::Nowhere);
    CHECK(bisector(Sphere{{0, 0, 0}, 1}, Sphere{{0, 1, 0}, 0}).kind == Kind::Line);
}

TEST_CASE("bisector: special positions are lost one ulp away") {
    const auto up = [](double x) { return std::nextafter(x, 10.0); };
    const Plane floor{{0, 0, 0}, {0, 0, 1}};
    const Cylinder pipe{{0, 0, 2}, {1, 0.5, 0.25}, 0.5};
    CHECK(bisector(floor, Plane{{0, 0, 1}, {0, 1e-300, 1}}).kind == Kind::PairOfPlanes);
    CHECK(bisector(floor, Cylinder{{0, 0, 2}, {1, 0.5, 1e-300}, 0.5}).kind == Kind::EllipticCone);
    CHECK(bisector(floor, Cylinder{{0, 0, 2}, {0, 1e-300, 1}, 0.5}).kind == Kind::EllipticCone);
    CHECK(bisector(Sphere{{0, 0, 0}, 1}, Sphere{{1, 2, 3}, up(1)}).kind == Kind::Hyperboloid);
    CHECK(bisector(Sphere{{0, 0, 0}, 3}, Sphere{{1e-300, 0, 0}, 0.5}).kind == Kind::Ellipsoid);
    CHECK(bisector(Sphere{{0, 0, 0}, 1}, Sphere{{0.5, 0, 0}, 0.5}).kind == Kind::Ellipsoid);
    CHECK(bisector(Sphere{{0, 0, 0}, 1}, Sphere{{0.5, 0, 0}, up(0.5)}).kind == Kind::Hyperboloid);
    CHECK(bisector(Sphere{{0, 0, 5}, up(0.5)}, pipe).kind == Kind::Quartic);
    CHECK(bisector(Cylinder{{0, 0, up(2)}, {0, 1, 1}, 0.5}, pipe).kind == Kind::HyperbolicParaboloid);
    CHECK(bisector(Cylinder{{0, 0, 2}, {0, 1, 1}, up(0.5)}, pipe).kind == Kind::Quartic);
    CHECK(bisector(Cylinder{{0, 0, 5}, {2, 1, up(0.5)}, 1}, pipe).kind == Kind::Quartic);
    CHECK(bisector(Cylinder{{up(2), 1, 2.5}, {2, 1, 0.5}, 2}, pipe).kind == Kind::EllipticCylinder);
}

TEST_CASE("bisector: points of patches are equally far from both objects, and on the polynomial") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vec = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    std::array<std::array<int, 3>, 3> checked{};
    for (int round = 0; round < 60; ++round) {
        const double radius = round % 4 == 0 ? 0 : 0.2 + 0.2 * unit(rng);
        const auto object = [&](std::size_t type, const Vec3& at, double r) -> Object {
            if (type == 0) return Plane{at, vec()};
            if (type == 1) return Sphere{at, r};
            return Cylinder{at, std::exp(5 * unit(rng)) * vec(), r};
        };
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                CAPTURE(i);
                CAPTURE(j);
                const Object base = object(i, vec(), radius);
                const Object a = object(j, vec() + Vec3(0, 0, 3), round % 3 == 0 ? radius : 0.4);
                for (const int sheet : {0, 1})
                    checked[i][j] += check_patch(base, a, {-0.4, 0.3}, {-0.2, 0.5}, false, sheet);
            }
    }
    for (const auto& row : checked)
        for (const int n : row) CHECK(n > 200);
}

TEST_CASE("bisector: patches in special positions") {
    const Plane floor{{0, 0, 0}, {0, 0, 1}};
    const Cylinder pipe{{0, 0, 2}, {1, 0.5, 0.25}, 0.5}, upright{{3, 0, 0}, {0, 0, 2}, 0.5};
    const std::array<double, 2> u{-0.5, 0.25}, v{-0.25, 0.5};
    CHECK(check_patch(floor, Cylinder{{0, 0, 2}, {1, 0.5, 0}, 0.5}, u, v) == 49);
    CHECK(check_patch(floor, upright, u, v) > 20);
    CHECK(check_patch(floor, Cylinder{{1, 2, 0}, {1, 1, 0}, 0}, u, v) == 49);
    CHECK(check_patch(Sphere{{0, 0, 0}, 1}, Sphere{{1, 2, 3}, 1}, u, v) == 49);
    CHECK(check_patch(Sphere{{0, 0, 0}, 3}, Sphere{{1, 0, 1}, 0.5}, u, v, true) == 49);
    CHECK(check_patch(Sphere{{1, 0, 1}, 3}, Sphere{{1, 0, 1}, 0.5}, u, v, true) == 49);
    CHECK(check_patch(Sphere{{0, 0, 5}, 0.5}, pipe, u, v) == 49);
    CHECK(check_patch(Sphere{{2, 1, 2.5}, 0.25}, Cylinder{{0, 0, 2}, {1, 0.5, 0.25}, 0.75}, u, v, true) ==
          49);
    // Of crossing axes the normals leave on the same side of both.
    CHECK(check_patch(pipe, Cylinder{{0, 0, 2}, {0, 1, 1}, 1}, {-0.125, 0.25}, {1.5, 2.5}) == 49);
    CHECK(check_patch(pipe, Cylinder{{1, 0, 5}, {0, 1, 1}, 0.5}, u, v) == 49);
    for (const int sheet : {0, 1})
        CHECK(check_patch(pipe, Cylinder{{0, 0, 2}, {0, 1, 1}, 0.5}, u, v, false, sheet) == 49);
    CHECK(check_patch(pipe, Cylinder{{0, 0, 5}, {-2, -1, -0.5}, 1}, u, v) == 49);
    CHECK(check_patch(pipe, Cylinder{{0, 0, 5}, {2, 1, 0.5}, 0.5}, u, v) == 49);
    CHECK(check_patch(pipe, Cylinder{{0, 0.25, 2}, {2, 1, 0.5}, 2}, u, v, true) == 49);
    CHECK(check_patch(pipe, Cylinder{{2, 1, 2.5}, {2, 1, 0.5}, 2}, u, v, true) == 49);
    // Beyond the directions in which a hyperboloid goes to infinity there is no patch.
    CHECK_FALSE(bisector_patch(Sphere{{0, 0, 0}, 1}, Sphere{{1, 2, 3}, 0.5}, {-2, 2}, {-2, 2}));
    CHECK_FALSE(bisector_patch(floor, floor, u, v));
}

// From (3, 4, 12) the origin is 13 away; the wall too is 4/5 of the 20 from its apex less 3/5 of 5 from its
// axis, or 8 where the apex is nearer.
TEST_CASE("bisector: that of a ball and a hollow cone holds points of small integers exactly") {
    const ExactVector p(Vec3(3, 4, 12)), q(Vec3(-5, 0, 12)), beside(Vec3(3, 4, 11));
    for (const auto& [radius, apex] : {std::pair{0.0, -8.0}, {5.0, -1.75}}) {
        CAPTURE(radius);
        const HollowCone cone{{0, 0, apex}, {0, 0, 3}, 4, 5};
        const Bisector b = bisector(Sphere{{0, 0, 0}, radius}, cone);
        CHECK(b.kind == Kind::Quartic);
        CHECK(b.degree() == 4);
        CHECK(b.polynomial(p).sign() == Sign::Zero);
        CHECK(b.polynomial(q).sign() == Sign::Zero);
        CHECK(b.polynomial(beside).sign() != Sign::Zero);
        CHECK_FALSE(bisector_patch(Sphere{{0, 0, 0}, radius}, cone, {-1, 1}, {-1, 1}));
    }
    CHECK_THROWS_AS(bisector(Plane{}, HollowCone{}), InputError);
}

// (3, 4, 12) is 5 from the axis of z, and from another one; 4/5 of 10 less 3/5 of 5 is as much.
TEST_CASE("bisector: those of a cylinder with vessels hold points of small integers exactly") {
    const ExactVector p(Vec3(3, 4, 12)), beside(Vec3(3, 4, 11));
    const Cylinder upright{{0, 0, 7}, {0, 0, 2}, 0}, across{{0, 7, 8}, {0, 1, 0}, 1};
    const auto holds = [&](const Cylinder& base, const Object& vessel, Kind kind, int degree) {
        const Bisector b = bisector(base, vessel);
        CHECK(b.kind == kind);
        CHECK(b.degree() == degree);
        CHECK(b.polynomial(p).sign() == Sign::Zero);
        CHECK(b.polynomial(beside).sign() != Sign::Zero);
        CHECK(bisector(vessel, base).kind == kind);
        CHECK_FALSE(bisector_patch(base, vessel, {-1, 1}, {-1, 1}));
    };
    holds(upright, HollowCone{{0, 0, 2}, {0, 0, 3}, 4, 5}, Kind::CircularCone, 4);
    holds(across, HollowCone{{0, 0, 3.25}, {0, 0, 3}, 4, 5}, Kind::Quartic, 4);
    // 13 from the origin, 5 from (0, 1, 12) across the axis of x.
    holds(across, HollowSphere{{0, 0, 0}, 17}, Kind::Quartic, 4);
    holds(across, HollowCylinder{{7, 1, 8}, {1, 0, 0}, 9}, Kind::Quartic, 4);
    const Bisector around = bisector(upright, HollowCylinder{{0, 0, 0}, {0, 0, -1}, 10}),
                   beside_it = bisector(upright, HollowCylinder{{1, 0, 0}, {0, 0, -1}, 10});
    CHECK(around.kind == Kind::CircularCylinder);
    CHECK(beside_it.kind == Kind::EllipticCylinder);
    CHECK(around.polynomial(p).sign() == Sign::Zero);
}

}  // namespace vcell::bisector_test
