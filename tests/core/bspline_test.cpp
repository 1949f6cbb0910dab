#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../../core/curves/bspline.hpp"
#include "../../core/curves/restricted_curve.hpp"
#include "../test_support.hpp"

namespace vcell::bspline_test {

namespace {

/// A clamped curve with control points, weights and inner knots (some double) at random.
RationalCurve3 random_curve(std::mt19937_64& rng, int degree) {
    std::uniform_real_distribution<double> coordinate(-1, 1), weight(0.5, 2);
    RationalCurve3 curve;
    curve.degree = degree;
    curve.knots.assign(degree + 1, -1.0);
    double knot = -1;
    for (auto inner = rng() % 4; inner > 0; --inner) {
        knot += weight(rng);
        curve.knots.push_back(knot);
        if (degree > 1 && rng() % 2) curve.knots.push_back(knot);
    }
    curve.knots.insert(curve.knots.end(), degree + 1, knot + weight(rng));
    while (curve.knots.size() != curve.points.size() + degree + 1) {
        curve.points.emplace_back(coordinate(rng), coordinate(rng), coordinate(rng), weight(rng));
    }
    return curve;
}

/// B_{i,p}(t) by the definition of Cox and de Boor, half-open spans.
double basis(const Knots& knots, int i, int p, double t) {
    if (p == 0) return knots[i] <= t && t < knots[i + 1] ? 1 : 0;
    double value = 0;
    if (knots[i + p] > knots[i])
        value += (t - knots[i]) / (knots[i + p] - knots[i]) * basis(knots, i, p - 1, t);
    if (knots[i + p + 1] > knots[i + 1]) {
        value += (knots[i + p + 1] - t) / (knots[i + p + 1] - knots[i + 1]) * basis(knots, i + 1, p - 1, t);
    }
    return value;
}

double bernstein(int n, int i, double t) {
    return std::tgamma(n + 1) / (std::tgamma(i + 1) * std::tgamma(n - i + 1)) * std::pow(t, i) *
           std::pow(1 - t, n - i);
}

RationalPatch random_patch(std::mt19937_64& rng, int degree_u, int degree_v) {
    std::uniform_real_distribution<double> coordinate(-1, 1), weight(0.5, 2);
    RationalPatch patch{degree_u, degree_v, {-2, 1}, {3, 3.5}, {}};
    for (int k = 0; k < (degree_u + 1) * (degree_v + 1); ++k) {
        patch.points.emplace_back(coordinate(rng), coordinate(rng), coordinate(rng), weight(rng));
    }
    return patch;
}

}  // namespace

TEST_CASE("rational curve: a part of it is the curve between its ends") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 200; ++i) {
        const RationalCurve3 curve = random_curve(rng, 1 + i % 5);
        const auto place = [&] {
            // Knots, the ends of the domain among them, and places between.
            const double s = std::uniform_real_distribution(0.0, 1.0)(rng);
            return rng() % 2 == 0 ? curve.knots[rng() % curve.knots.size()]
                                  : std::lerp(curve.domain_begin(), curve.domain_end(), s);
        };
        const double a = place(), b = place();
        if (a == b) continue;
        CAPTURE(a);
        CAPTURE(b);
        const double from = std::min(a, b), to = std::max(a, b);
        const RationalCurve3 part = restricted(curve, from, to);
        CHECK(part.domain_begin() == from);
        CHECK(part.domain_end() == to);
        REQUIRE(part.knots.size() == part.points.size() + part.degree + 1);
        CHECK(std::count(part.knots.begin(), part.knots.end(), from) == part.degree + 1);
        CHECK(std::count(part.knots.begin(), part.knots.end(), to) == part.degree + 1);
        for (int k = 0; k <= 20; ++k) {
            const double t = std::lerp(from, to, k / 20.0);
            // Where a knot is as often as the degree says the curve may have two points.
            if (std::count(curve.knots.begin(), curve.knots.end(), t) > curve.degree) continue;
            CHECK((part.evaluate(t) - curve.evaluate(t)).norm() < 1e-12);
        }
    }
}

TEST_CASE("RationalCurve: agrees with the basis functions' definition") {
    std::mt19937_64 rng(test_seed());
    for (int degree = 1; degree <= 5; ++degree) {
        for (int i = 0; i < 50; ++i) {
            const RationalCurve3 curve = random_curve(rng, degree);
            const double t = std::uniform_real_distribution(curve.domain_begin(), curve.domain_end())(rng);
            Eigen::Vector4d sum = Eigen::Vector4d::Zero();
            for (std::size_t k = 0; k < curve.points.size(); ++k) {
                const double b = basis(curve.knots, static_cast<int>(k), degree, t) * curve.points[k](3);
                sum += b * Eigen::Vector4d(curve.points[k](0), curve.points[k](1), curve.points[k](2), 1);
            }
            CAPTURE(degree);
            CAPTURE(t);
            CHECK((curve.evaluate(t) - sum.head<3>() / sum(3)).norm() < 1e-13);
        }
    }
}

TEST_CASE("RationalCurve: runs from the first control point to the last, and stays there") {
    std::mt19937_64 rng(test_seed());
    for (int degree = 1; degree <= 4; ++degree) {
        const RationalCurve3 curve = random_curve(rng, degree);
        const Eigen::Vector3d first = curve.points.front().head<3>(), last = curve.points.back().head<3>();
        CHECK((curve.evaluate(curve.domain_begin()) - first).norm() < 1e-14);
        CHECK((curve.evaluate(curve.domain_end()) - last).norm() < 1e-14);
        CHECK((curve.evaluate(curve.domain_begin() - 7) - first).norm() < 1e-14);
        CHECK((curve.evaluate(curve.domain_end() + 7) - last).norm() < 1e-14);
    }
}

TEST_CASE("RationalCurve: derivative is that of nearby points") {
    std::mt19937_64 rng(test_seed());
    for (int degree = 1; degree <= 5; ++degree) {
        for (int i = 0; i < 50; ++i) {
            const RationalCurve3 curve = random_curve(rng, degree);
            const double t = std::uniform_real_distribution(curve.domain_begin(), curve.domain_end())(rng);
            const double h = 1e-6;
            bool near_knot = t - h < curve.domain_begin() || t + h > curve.domain_end();
            for (const double knot : curve.knots) near_knot |= std::abs(t - knot) < 2 * h;
            if (near_knot) continue;
            const auto [point, derivative] = curve.evaluate_with_derivative(t);
            const Eigen::Vector3d slope = (curve.evaluate(t + h) - curve.evaluate(t - h)) / (2 * h);
            CAPTURE(degree);
            CAPTURE(t);
            CHECK(point == curve.evaluate(t));
            CHECK((derivative - slope).norm() < 1e-6 * (1 + derivative.norm()));
        }
    }
}

TEST_CASE("RationalCurve: a rational quadratic is a circle") {
    // The half circle of radius 2 about (1, -1), as two quarters.
    const double w = std::sqrt(0.5);
    const RationalCurve2 circle{
        2, {0, 0, 0, 1, 1, 2, 2, 2}, {{3, -1, 1}, {3, 1, w}, {1, 1, 1}, {-1, 1, w}, {-1, -1, 1}}};
    for (int i = 0; i <= 100; ++i) {
        const auto [p, d] = circle.evaluate_with_derivative(i * 0.02);
        const Eigen::Vector2d radial = p - Eigen::Vector2d(1, -1);
        CHECK(radial.norm() == doctest::Approx(2).epsilon(1e-14));
        CHECK(std::abs(radial.dot(d)) < 1e-13);
        CHECK(radial.x() * d.y() - radial.y() * d.x() > 0);  // counter-clockwise
    }
}

TEST_CASE("RationalPatch: agrees with the Bernstein polynomials, outside its domain too") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> inside(0, 1), around(-0.1, 1.1);
    for (int i = 0; i < 100; ++i) {
        const RationalPatch patch =
            random_patch(rng, 1 + static_cast<int>(rng() % 4), 1 + static_cast<int>(rng() % 4));
        const double s = i % 2 ? inside(rng) : around(rng), t = i % 2 ? inside(rng) : around(rng);
        Eigen::Vector4d sum = Eigen::Vector4d::Zero();
        for (int a = 0; a <= patch.degree_u; ++a) {
            for (int b = 0; b <= patch.degree_v; ++b) {
                const Eigen::Vector4d& p = patch.point(a, b);
                sum += bernstein(patch.degree_u, a, s) * bernstein(patch.degree_v, b, t) * p(3) *
                       Eigen::Vector4d(p(0), p(1), p(2), 1);
            }
        }
        const Eigen::Vector3d point = patch.evaluate(-2 + 3 * s, 3 + 0.5 * t);
        CAPTURE(s);
        CAPTURE(t);
        CHECK((point - sum.head<3>() / sum(3)).norm() < 1e-12 * (1 + point.norm()));
    }
}

TEST_CASE("RationalPatch: partial derivatives are those of nearby points") {
    std::mt19937_64 rng(test_seed());
    const double h = 1e-6;
    for (int i = 0; i < 100; ++i) {
        const RationalPatch patch =
            random_patch(rng, 1 + static_cast<int>(rng() % 3), 1 + static_cast<int>(rng() % 3));
        const double u = std::uniform_real_distribution(-2.0, 1.0)(rng);
        const double v = std::uniform_real_distribution(3.0, 3.5)(rng);
        const auto [du, dv] = patch.partials(u, v);
        const Eigen::Vector3d slope_u = (patch.evaluate(u + h, v) - patch.evaluate(u - h, v)) / (2 * h);
        const Eigen::Vector3d slope_v = (patch.evaluate(u, v + h) - patch.evaluate(u, v - h)) / (2 * h);
        CAPTURE(u);
        CAPTURE(v);
        CHECK((du - slope_u).norm() < 1e-6 * (1 + du.norm()));
        CHECK((dv - slope_v).norm() < 1e-6 * (1 + dv.norm()));
    }
}

TEST_CASE("RationalPatch: a biquadratic is the paraboloid midway between a plane and a point") {
    // The point (0, 0, 1) over z = 0: z = (x^2 + y^2 + 1) / 2 on [-1, 1] x [0, 2], control points by
    // blossoming.
    RationalPatch patch{2, 2, {-1, 1}, {0, 2}, {}};
    const std::array<double, 3> x{-1, 0, 1}, xx{1, -1, 1}, y{0, 1, 2}, yy{0, 0, 4};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) patch.points.emplace_back(x[i], y[j], (xx[i] + yy[j] + 1) / 2, 1);
    }
    for (double u = -1; u <= 1; u += 0.125) {
        for (double v = 0; v <= 2; v += 0.125) {
            const Eigen::Vector3d p = patch.evaluate(u, v);
            CHECK(p.x() == doctest::Approx(u).epsilon(1e-14));
            CHECK(p.y() == doctest::Approx(v).epsilon(1e-14));
            CHECK((p - Eigen::Vector3d(0, 0, 1)).norm() == doctest::Approx(p.z()).epsilon(1e-14));
        }
    }
}

}  // namespace vcell::bspline_test
