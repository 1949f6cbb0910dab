// Four spheres: the closed form of their equidistant points, in rational arithmetic up to one square
// root in multiprecision, against the solver.
#include <doctest/doctest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <random>
#include <vector>

#include "../../primitives/bisectors/vertex_roots.hpp"
#include "../test_support.hpp"

namespace vcell::apollonius_test {
using Rational = boost::multiprecision::cpp_rational;

namespace {

struct Balls {
    std::array<std::array<Rational, 3>, 4> center;
    std::array<Rational, 4> radius;
};

Rational det3(const std::array<std::array<Rational, 3>, 3>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

Wide enclosed(const Rational& q) {
    using boost::multiprecision::denominator;
    using boost::multiprecision::numerator;
    const auto integer = [](const boost::multiprecision::cpp_int& n) {
        const Wide::Float f(n);
        return Wide(f, f) * (Wide(1.0) + Wide(-0x1p-310, 0x1p-310));
    };
    return integer(numerator(q)) / integer(denominator(q));
}

/// |p - c_i|^2 = (r + rho_i)^2: the differences to the first are linear, so p = a + b r; what remains is
/// quadratic in r. Nothing when the centres are coplanar or the roots (nearly) coincide.
std::optional<std::vector<WideBox<4>>> closed_form(const Balls& s) {
    std::array<std::array<Rational, 3>, 3> m;
    std::array<std::array<Rational, 2>, 3> right;  // constant, times r
    const auto norm2 = [](const std::array<Rational, 3>& c) -> Rational {
        return c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    };
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) m[i][j] = 2 * (s.center[i + 1][j] - s.center[0][j]);
        right[i][0] = norm2(s.center[i + 1]) - norm2(s.center[0]) - s.radius[i + 1] * s.radius[i + 1] +
                      s.radius[0] * s.radius[0];
        right[i][1] = 2 * (s.radius[0] - s.radius[i + 1]);
    }
    const Rational det = det3(m);
    if (det == 0) return std::nullopt;
    std::array<std::array<Rational, 2>, 3> p;
    for (int j = 0; j < 3; ++j)
        for (int e = 0; e < 2; ++e) {
            auto column = m;
            for (int i = 0; i < 3; ++i) column[i][j] = right[i][e];
            p[j][e] = det3(column) / det;
        }
    Rational A = -1, B = -2 * s.radius[0], C = -s.radius[0] * s.radius[0];
    for (int j = 0; j < 3; ++j) {
        const Rational k = p[j][0] - s.center[0][j];
        A += p[j][1] * p[j][1];
        B += 2 * k * p[j][1];
        C += k * k;
    }
    const Rational discriminant = B * B - 4 * A * C;
    if (A == 0 || discriminant == 0) return std::nullopt;
    std::vector<WideBox<4>> points;
    if (discriminant < 0) return points;
    for (const double sign : {-1.0, 1.0}) {
        const Wide r = (Wide(sign) * sqrt(enclosed(discriminant)) - enclosed(B)) / enclosed(2 * A);
        WideBox<4> x;
        for (int j = 0; j < 3; ++j) x[j] = enclosed(p[j][0]) + enclosed(p[j][1]) * r;
        x[3] = r;
        points.push_back(x);
    }
    return points;
}

VertexSystem random_balls(std::mt19937_64& rng, bool coarse) {
    std::uniform_real_distribution<double> coordinate(-8, 8), radius(0.125, 3);
    const auto snap = [&](double v) { return coarse ? std::round(4 * v) / 4 : v; };
    VertexSystem s;
    for (auto& site : s.sites)
        site = SphereSite{{snap(coordinate(rng)), snap(coordinate(rng)), snap(coordinate(rng))},
                          snap(radius(rng))};
    return s;
}

Balls exact(const VertexSystem& s) {
    Balls balls;
    for (int k = 0; k < 4; ++k) {
        const auto& sphere = std::get<SphereSite>(s.sites[k]);
        for (int j = 0; j < 3; ++j) balls.center[k][j] = Rational(sphere.center[j]);
        balls.radius[k] = Rational(sphere.radius);
    }
    return balls;
}

}  // namespace

TEST_CASE("solver: random spheres have the equidistant points of the closed form") {
    std::mt19937_64 rng(test_seed());
    std::array<int, 3> by_count{};
    for (int n = 0; n < long_rounds(600); ++n) {
        const VertexSystem system = random_balls(rng, n % 2 == 0);
        const auto points = closed_form(exact(system));
        if (!points) continue;
        const IntervalBox<4> box{Interval(-20, 20), Interval(-20, 20), Interval(-20, 20),
                                 Interval(system.least_clearance(), 40)};
        const WideBox<4> wide_box = converted<Wide>(box);
        std::vector<WideBox<4>> inside;
        for (const auto& p : *points)
            if (overlap(p, wide_box)) inside.push_back(p);

        const auto found = solve(system, box);
        CAPTURE(n);
        CHECK(found.undecided.empty());
        REQUIRE(found.unique.size() == inside.size());
        for (const auto& p : inside) {
            int holders = 0;
            for (const auto& root : found.unique) {
                if (!overlap(converted<Wide>(root.box), p)) continue;
                ++holders;
                const WideBox<4> refined = refine(system, root, 120);
                CHECK(overlap(refined, p));
                for (const Wide& side : refined) CHECK(side.radius_exponent() < -110);
            }
            CHECK(holders == 1);
        }
        ++by_count[inside.size()];
    }
    for (const int count : by_count) CHECK(count > long_rounds(4));
}

TEST_CASE("vertex system: its points are equidistant from plane, spheres and cylinders") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> coordinate(-6, 6), radius(0.1, 1), direction(-1, 1);
    const auto three = [&](auto& distribution) {
        return std::array{distribution(rng), distribution(rng), distribution(rng)};
    };
    int vertices = 0;
    for (int n = 0; n < 60; ++n) {
        VertexSystem system;
        system.sites[0] = PlaneSite{three(direction), 8.0};
        system.sites[1] = SphereSite{three(coordinate), radius(rng)};
        for (int k = 2; k < 4; ++k)
            system.sites[k] = CylinderSite{three(coordinate), three(direction), radius(rng)};
        const auto found =
            solve(system, IntervalBox<4>{Interval(-10, 10), Interval(-10, 10), Interval(-10, 10),
                                         Interval(system.least_clearance(), 30)});
        CHECK(found.undecided.empty());
        for (const auto& root : found.unique) {
            ++vertices;
            const Point<4> v = mid(root.box);
            const auto dot = [](const auto& a, const auto& b) {
                return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            };
            for (const auto& site : system.sites) {
                double distance = 0;
                if (const auto* plane = std::get_if<PlaneSite>(&site)) {
                    distance = (dot(plane->normal, v) + plane->offset) /
                               std::sqrt(dot(plane->normal, plane->normal));
                } else if (const auto* sphere = std::get_if<SphereSite>(&site)) {
                    const auto& c = sphere->center;
                    distance = std::hypot(v[0] - c[0], v[1] - c[1], v[2] - c[2]) - sphere->radius;
                } else {
                    const auto& cylinder = std::get<CylinderSite>(site);
                    const auto& [p, d, rho] = cylinder;
                    const std::array w{v[0] - p[0], v[1] - p[1], v[2] - p[2]};
                    const std::array cross{w[1] * d[2] - w[2] * d[1], w[2] * d[0] - w[0] * d[2],
                                           w[0] * d[1] - w[1] * d[0]};
                    distance = std::sqrt(dot(cross, cross) / dot(d, d)) - rho;
                }
                CHECK(distance == doctest::Approx(v[3]).epsilon(1e-9));
            }
        }
    }
    CHECK(vertices > 30);
}

}  // namespace vcell::apollonius_test
