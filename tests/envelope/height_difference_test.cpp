// Differences of heights by Taylor's formula: quadratic functions with second derivatives in known ranges.
#include <doctest/doctest.h>

#include <random>

#include "../../envelope/proofs/height_difference.hpp"
#include "../test_support.hpp"

namespace vcell::height_difference_test {
namespace {

class Samples {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }

private:
    std::mt19937_64 rng_{test_seed()};
};

struct Quadratic {
    double v, gx, gy, xx, xy, yy;

    double at(double x, double y) const {
        return v + gx * x + gy * y + 0.5 * (xx * x * x + 2 * xy * x * y + yy * y * y);
    }
    // Over |x|, |y| <= 1, second derivatives known within `width`.
    HeightDifference difference(double width) const {
        const auto about = [&](double c) { return Interval(c - width, c + width); };
        return {{v, gx, gy}, {0.0, 0.0, 0.0}, {about(xx), about(xy), about(yy)}, {-1, 1}, {-1, 1}};
    }
};

TEST_CASE("height difference: a common zero lies in the part that is left of a box") {
    Samples samples;
    int smaller = 0, none = 0;
    for (int round = 0; round < 2000; ++round) {
        const double x = samples.number(-1, 1), y = samples.number(-1, 1), bend = samples.number(0, 2);
        const auto through = [&] {
            Quadratic q{0,
                        samples.number(-2, 2),
                        samples.number(-2, 2),
                        samples.number(-bend, bend),
                        samples.number(-bend, bend),
                        samples.number(-bend, bend)};
            q.v = -q.at(x, y);
            return q;
        };
        Quadratic p = through();
        const Quadratic q = through();
        const double width = samples.number(0.001, 0.3);
        const auto where = common_zeros(p.difference(width), q.difference(width));
        REQUIRE(where.has_value());
        const auto& [dx, dy] = *where;
        CHECK((dx.lower() <= x + 1e-12 && x - 1e-12 <= dx.upper()));
        CHECK((dy.lower() <= y + 1e-12 && y - 1e-12 <= dy.upper()));
        smaller += dx.width() * dy.width() < 1;
        p.v += 20;  // more than it changes by
        none += !common_zeros(p.difference(width), q.difference(width));
    }
    CHECK(smaller > 500);
    CHECK(none > 500);
}

TEST_CASE("height difference: values, slopes and bends hold for all second derivatives in their ranges") {
    Samples samples;
    int concave = 0, convex = 0;
    for (int round = 0; round < 2000; ++round) {
        const auto number = [&] { return samples.number(-2, 2); };
        const Quadratic q{number(), number(), number(), number(), number(), number()};
        const double width = samples.number(0.001, 0.5);
        const HeightDifference d = q.difference(width);
        Quadratic member = q;
        for (double* c : {&member.xx, &member.xy, &member.yy}) *c += width * samples.number(-1, 1);
        const double x = samples.number(-1, 1), y = samples.number(-1, 1);
        CHECK(d.value(x, y).contains(member.at(x, y)));
        const double gx = member.gx + member.xx * x + member.xy * y,
                     gy = member.gy + member.xy * x + member.yy * y;
        const auto gradient = d.gradient(x, y);
        CHECK(gradient[0].contains(gx));
        CHECK(gradient[1].contains(gy));
        const Eigen::Vector2d u = Eigen::Vector2d(number(), number()).normalized();
        CHECK(d.slope_along(u).contains(u.x() * gx + u.y() * gy));
        // Eigenvalues of the member have one sign as the test says.
        const double trace = member.xx + member.yy, det = member.xx * member.yy - member.xy * member.xy;
        if (d.is_convex()) CHECK((det > 0 && trace > 0));
        if (d.is_concave_somewhere()) CHECK((det < 0 || trace < 0));
        convex += d.is_convex();
        concave += d.is_concave_somewhere();
        const auto s = d.stationary();
        if (s.offset.allFinite() && s.offset.norm() < 100)
            CHECK(q.at(s.offset.x(), s.offset.y()) == doctest::Approx(s.value).epsilon(1e-6));
    }
    CHECK(convex > 50);
    CHECK(concave > 500);
}

}  // namespace
}  // namespace vcell::height_difference_test
