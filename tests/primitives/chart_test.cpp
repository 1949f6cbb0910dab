#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/charts/chart.hpp"
#include "../test_support.hpp"

namespace vcell::chart_test {
namespace {

struct Sample {
    BaseChart chart;
    Vec2 place;
};

// Charts over every base, turned as their bases allow, with a place in each.
class Samples {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    Sample next() {
        const int kind = count_++ % 3;
        const double angle = number(-3, 3), c = std::cos(angle), s = std::sin(angle), y = number(-3, 3);
        BaseChart chart;
        if (kind > 0) chart.radius = number(0, 2);
        if (kind > 0) chart.turn << c, 0, s, 0, 1, 0, -s, 0, c;
        if (kind == 1) chart = {BaseShape::Sphere, chart.radius, chart.turn};
        if (kind == 2) chart = {BaseShape::Cylinder, chart.radius, chart.turn};
        return {chart, {chart.is_cylinder() ? number(-1, 3) : number(-3, 3), y}};
    }

private:
    std::mt19937_64 rng_{test_seed()};
    int count_ = 0;
};

}  // namespace

TEST_CASE("chart: a point over a place has it for its chart point, and its distance from the foot") {
    Samples samples;
    for (int i = 0; i < 3000; ++i) {
        const auto [chart, q] = samples.next();
        CAPTURE(q.x());
        CAPTURE(q.y());
        const double t = samples.number(0.1, 5);
        const Vec3 p = chart.point(q, t);
        const Eigen::Vector4d X = chart.with_distance(p);
        CHECK(X[3] == doctest::Approx(t).epsilon(1e-14));
        CHECK((chart.chart_point(X) - q).norm() <= chart.chart_error(X, q, 0, 1e-14));
        CHECK((p - chart.foot_below(p)).norm() == doctest::Approx(t).epsilon(1e-14));
        CHECK(chart.distance(chart.base_point(q)) == doctest::Approx(chart.radius).epsilon(1e-14));
    }
}

TEST_CASE("chart: normals in intervals hold those in doubles, and W is that of half the angle") {
    Samples samples;
    for (int i = 0; i < 3000; ++i) {
        const auto [chart, q] = samples.next();
        const Interval x(q.x()), y(q.y());
        const bool is_back = chart.is_back(q.x());
        const auto u = chart.normal(x, y, is_back, Interval::ball(0, 1e-15));
        const Vec3 n = chart.normal(q);
        for (int k = 0; k < 3; ++k) CHECK((u[k] + Interval::ball(0, 1e-15)).contains(n[k]));
        const double W = chart.weight(x, y, is_back).mid(), tangent = chart.half_tangent(q);
        CHECK(W == doctest::Approx(1 + tangent * tangent).epsilon(1e-14));
        if (!chart.is_plane()) CHECK(chart.distance_of(q, -2) == doctest::Approx(W / 2).epsilon(1e-14));
        // What the forms' own coordinates tell, without the turn.
        const BaseChart straight{static_cast<const Chart&>(chart), chart.radius};
        const Vec3 p = straight.point(q, 2);
        const auto back = chart.Chart::chart_point<Interval>({p.x(), p.y(), p.z()}, 1);
        for (int k = 0; k < 2; ++k) CHECK((back[k] + Interval::ball(0, 1e-12)).contains(q[k]));
    }
}

TEST_CASE("chart: derivatives of normals are limits of differences") {
    Samples samples;
    for (int i = 0; i < 3000; ++i) {
        const auto [chart, q] = samples.next();
        constexpr double step = 1e-6;
        const Vec2 d(samples.number(-1, 1), samples.number(-1, 1)), ahead = q + step * d,
                                                                    behind = q - step * d;
        if (chart.is_back(ahead.x()) != chart.is_back(behind.x())) continue;
        const Vec3 difference = (chart.normal(ahead) - chart.normal(behind)) / (2 * step);
        CHECK((difference - chart.normal_derivative(q, d)).norm() < 1e-8);
    }
}

TEST_CASE("chart: around a cylinder places are continued, and boxes are cut where halves meet") {
    const BaseChart around{BaseShape::Cylinder, 1}, flat;
    CHECK(around.continued({-0.9, 5}, {2.5, 3.5, 4, 6}) == Vec2(3.1, 5));
    CHECK(flat.continued({-0.9, 5}, {2.5, 3.5, 4, 6}) == Vec2(-0.9, 5));
    std::vector<Chart::Part> parts;
    const auto add = [&](const Chart::Part& part) { parts.push_back(part); };
    around.for_parts({0.5, 1.5, 2, 3}, add);
    REQUIRE(parts.size() == 2);
    CHECK(parts[0].box == std::array<double, 4>{0.5, 1, 2, 3});
    CHECK(!parts[0].is_back);
    CHECK(parts[1].box == std::array<double, 4>{1, 1.5, 2, 3});
    CHECK(parts[1].is_back);
    parts.clear();
    flat.for_parts({0.5, 1.5, 2, 3}, add);
    CHECK(parts.size() == 1);
    // Half of a sphere's stretch as seen from its centre.
    const ChartLength along = Chart(BaseShape::Sphere).lengths(0, 0);
    CHECK(along.inverse(0.5 * (along.at(0) + along.at(1))) == doctest::Approx(std::tan(std::atan(1.0) / 2)));
}

}  // namespace vcell::chart_test
