#include <doctest/doctest.h>

#include <random>

#include "../../core/solver/fit/curve_fit.hpp"
#include "curve_check.hpp"
#include "system_file.hpp"

using namespace vcell;
using namespace vcell::testing;

namespace {

// The largest distance found between the spline and the true curve, both ways: spline points to the true
// point with the same coordinate along the tube's axis, and true points to the nearest sample of the spline
// (refined in its neighbourhood). image: the map that was fitted, in double.
template <int N, int M, class Image>
double largest_distance(const CurveSystem<N>& f, const CurveComponent<N + 1>& component,
                        const RationalCurve<M>& spline, const Image& image, int samples) {
    std::vector<Eigen::Matrix<double, M, 1>> points;
    std::vector<double> at;
    for (int i = 0; i <= samples; ++i) {
        at.push_back(std::lerp(spline.domain_begin(), spline.domain_end(), i / double(samples)));
        points.push_back(spline.evaluate(at.back()));
    }
    double largest = 0;
    for (const Tube<N + 1>& tube : component.tubes)
        for (const double fraction : {0.11, 0.37, 0.52, 0.83}) {
            const auto x = image(true_point<N>(f, tube, std::lerp(tube.begin, tube.end, fraction)));
            std::size_t nearest = 0;
            for (std::size_t i = 0; i < points.size(); ++i)
                if ((points[i] - x).norm() < (points[nearest] - x).norm()) nearest = i;
            // Ternary search between the neighbours of the nearest sample.
            double lo = at[nearest == 0 ? 0 : nearest - 1], hi = at[std::min(nearest + 1, at.size() - 1)];
            for (int step = 0; step < 80; ++step) {
                const double a = std::lerp(lo, hi, 1 / 3.0), b = std::lerp(lo, hi, 2 / 3.0);
                ((spline.evaluate(a) - x).norm() < (spline.evaluate(b) - x).norm() ? hi : lo) =
                    (spline.evaluate(a) - x).norm() < (spline.evaluate(b) - x).norm() ? b : a;
            }
            largest = std::max(largest, (spline.evaluate(std::midpoint(lo, hi)) - x).norm());
        }
    return largest;
}

template <int M>
double arc_length(const RationalCurve<M>& spline, int samples) {
    double length = 0;
    for (int i = 0; i < samples; ++i) {
        const double a = std::lerp(spline.domain_begin(), spline.domain_end(), i / double(samples));
        const double b = std::lerp(spline.domain_begin(), spline.domain_end(), (i + 1) / double(samples));
        length += (spline.evaluate(b) - spline.evaluate(a)).norm();
    }
    return length;
}

// No corner between spans: the tangents before and behind each knot agree in direction.
template <int M>
double largest_turn(const RationalCurve<M>& spline) {
    double largest = 0;
    for (std::size_t i = 3; i + 3 < spline.points.size(); i += 3) {
        const auto p = [&](std::size_t k) { return spline.points[k].template head<M>().eval(); };
        const auto before = (p(i) - p(i - 1)).normalized(), behind = (p(i + 1) - p(i)).normalized();
        largest = std::max(largest, (before - behind).norm());
    }
    return largest;
}

}  // namespace

TEST_CASE("curve splines: the certified error bounds the distance to 200-bit points of plane curves") {
    const CurveSystem<1> f([](const auto& p) {
        return std::array{square(square(p[0])) + 3.0 * square(p[1]) - 1.0 + 0.5 * p[0] * p[1]};
    });
    const CurveSet<2> set = solve_curves<1>(f, {Interval(-2, 2), Interval(-2, 2)});
    REQUIRE(set.components.size() == 1);
    std::size_t spans = 0;
    for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
        CAPTURE(tolerance);
        const FittedCurve<2> fit = fit_curve<1, 2>(f, set.components[0], tolerance);
        CHECK(fit.error <= tolerance);
        const double found = largest_distance<1, 2>(
            f, set.components[0], fit.curve, [](const Point<2>& x) { return Eigen::Vector2d(x[0], x[1]); },
            2000);
        CHECK(found <= fit.error);
        CHECK(found > fit.error / 1000);  // the bound is no idle one
        CHECK(largest_turn(fit.curve) < 1e-6);
        CHECK((fit.curve.points.front() - fit.curve.points.back()).norm() == 0);  // closed
        CHECK(fit.curve.points.size() > spans);
        spans = fit.curve.points.size();
    }
}

TEST_CASE("curve splines: a tolerance below rounding is missed by a finite, stated error") {
    const CurveSystem<1> f([](const auto& p) { return std::array{square(p[0]) + square(p[1]) - 1.0}; });
    const CurveSet<2> set = solve_curves<1>(f, {Interval(-2, 2), Interval(-2, 0.5)});
    REQUIRE(set.components.size() == 1);
    const FittedCurve<2> fit = fit_curve<1, 2>(f, set.components[0], 1e-13);
    CHECK(fit.error < 1e-12);
    CHECK(fit.error > 0);
}

TEST_CASE("curve splines: curves of the system file have the stated arc length") {
    for (const auto& entry : solver_systems("curve")) {
        const std::string id = entry.at("id");
        CAPTURE(id);
        double length = 0, error = 0;
        constexpr double tolerance = 1e-7;
        if (entry.at("variables").size() == 2) {
            const CurveSystem<1> f(polynomials_of<1, 2>(entry));
            for (const auto& component : solve_curves<1>(f, box_of<2>(entry)).components) {
                const auto fit = fit_curve<1, 2>(f, component, tolerance);
                length += arc_length(fit.curve, 20'000);
                error = std::max(error, fit.error);
            }
        } else {
            const CurveSystem<3> f(polynomials_of<3, 4>(entry));
            for (const auto& component : solve_curves<3>(f, box_of<4>(entry)).components) {
                const auto fit = fit_curve<3, 3>(f, component, tolerance);
                length += arc_length(fit.curve, 20'000);
                error = std::max(error, fit.error);
            }
        }
        const std::string key = entry.contains("arc_length_xyz") ? "arc_length_xyz" : "arc_length";
        // At the end in a node the Jacobian degenerates.
        if (!entry.contains("singular_points")) CHECK(error <= tolerance);
        CHECK(length == doctest::Approx(std::stod(entry.at(key).get<std::string>())).epsilon(1e-6));
    }
}

TEST_CASE("curve splines: the image of a curve in the chart, within its certified error") {
    // The paraboloids z = x^2 + y^2 / 2 and z = 1 + (x y) / 4 over their common curve.
    const auto low = [](const auto& x, const auto& y) { return square(x) + 0.5 * square(y); };
    const auto high = [](const auto& x, const auto& y) { return 1.0 + 0.25 * x * y; };
    const CurveSystem<1> f([&](const auto& p) { return std::array{low(p[0], p[1]) - high(p[0], p[1])}; });
    const SmoothMap<2, 4> lifted([&](const auto& p) {
        const auto z = high(p[0], p[1]);
        return std::array{low(p[0], p[1]) - z, p[0], p[1], z};
    });
    const CurveSet<2> set = solve_curves<1>(f, {Interval(-3, 3), Interval(-3, 0.5)});
    REQUIRE(set.components.size() == 1);
    for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
        const FittedCurve<3> fit = fit_curve<1, 3>(lifted, set.components[0], tolerance);
        CHECK(fit.error <= tolerance);
        const double found = largest_distance<1, 3>(
            f, set.components[0], fit.curve,
            [&](const Point<2>& x) { return Eigen::Vector3d(x[0], x[1], high(x[0], x[1])); }, 2000);
        CHECK(found <= fit.error);
        CHECK(found > fit.error / 1000);
    }
}

TEST_CASE("curve splines: in space, from two equations in three unknowns") {
    // Viviani's window with its node cut off.
    const CurveSystem<2> f([](const auto& p) {
        return std::array{square(p[0]) + square(p[1]) + square(p[2]) - 4.0,
                          square(p[0] - 1.0) + square(p[1]) - 1.0};
    });
    const CurveSet<3> set = solve_curves<2>(f, {Interval(-1, 1.75), Interval(-2, 2), Interval(0.5, 3)});
    REQUIRE(set.complete());
    REQUIRE(set.components.size() == 1);
    const FittedCurve<3> fit = fit_curve<2, 3>(f, set.components[0], 1e-7);
    CHECK(fit.error <= 1e-7);
    const double found = largest_distance<2, 3>(
        f, set.components[0], fit.curve, [](const Point<3>& x) { return Eigen::Vector3d(x[0], x[1], x[2]); },
        2000);
    CHECK(found <= fit.error);
    CHECK(found > fit.error / 1000);
}

TEST_CASE("series: quotients and roots have the binomial coefficients") {
    const Series s({Interval(0.0), Interval(1.0), Interval(0.0), Interval(0.0), Interval(0.0)}, 1);
    const Series reciprocal = Series(1.0) / (Series(1.0) - s), root = sqrt(Series(1.0) + s);
    const std::array binomial{1.0, 0.5, -0.125, 0.0625, -0.0390625};
    for (int i = 0; i <= Series::order; ++i) {
        CHECK(reciprocal[i].contains(1.0));
        CHECK(root[i].contains(binomial[i]));
        CHECK(root[i].radius() < 1e-14);
        CHECK(square(root)[i].contains(i <= 1 ? 1.0 : 0.0));
        CHECK((root * root)[i].contains(i <= 1 ? 1.0 : 0.0));
        CHECK((reciprocal * (Series(1.0) - s) - Series(1.0))[i].contains(0.0));
    }
}
