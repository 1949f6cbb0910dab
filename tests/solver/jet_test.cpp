#include <doctest/doctest.h>

#include <random>

#include "../../core/solver/newton/box.hpp"
#include "../../core/solver/systems/polynomial.hpp"
#include "../test_support.hpp"

namespace vcell::jet_test {

namespace {

/// Every operation of jets once. Partials by hand in `expected`.
struct Everything {
    template <class T>
    std::array<T, 2> operator()(const std::array<T, 2>& p) const {
        using std::sqrt;
        const auto& [x, y] = p;
        T f = sqrt(x) * y - square(y) / x;
        f += T(3.0) * x;
        T g = -x + y;
        g -= x * y;
        g *= y;
        return {f, g};
    }
    static std::array<Point<2>, 2> expected(double x, double y) {
        return {{{y / (2 * std::sqrt(x)) + y * y / (x * x) + 3, std::sqrt(x) - 2 * y / x},
                 {-y - y * y, -x + 2 * y - 2 * x * y}}};
    }
};

}  // namespace

TEST_CASE("jet: partial derivatives are those of calculus, and enclosed in both interval arithmetics") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> coordinate(0.25, 4.0);
    for (int i = 0; i < 200; ++i) {
        const Point<2> p{coordinate(rng), coordinate(rng)};
        const IntervalBox<2> box{Interval(p[0] - 0.01, p[0] + 0.02), Interval(p[1] - 0.02, p[1] + 0.01)};
        const auto at_point = differentiate(Everything{}, p);
        const auto over_box = differentiate(Everything{}, box);
        const auto in_wide = differentiate(Everything{}, converted<Wide>(p));
        const auto expected = Everything::expected(p[0], p[1]);
        for (int k = 0; k < 2; ++k) {
            CHECK(over_box[k].value.contains(at_point[k].value));
            CHECK(in_wide[k].value.approximation() == doctest::Approx(at_point[k].value).epsilon(1e-12));
            for (int j = 0; j < 2; ++j) {
                CHECK(at_point[k].gradient[j] == doctest::Approx(expected[k][j]).epsilon(1e-12));
                CHECK(over_box[k].gradient[j].contains(expected[k][j]));
                CHECK(in_wide[k].gradient[j].approximation() ==
                      doctest::Approx(expected[k][j]).epsilon(1e-12));
                CHECK(in_wide[k].gradient[j].radius_exponent() < -250);
            }
        }
    }
}

TEST_CASE("power: even powers are never negative, odd ones keep the sign") {
    const Interval x(-2.0, 1.0);
    for (const unsigned n : {2u, 4u, 6u, 10u}) {
        CHECK(power(x, n).lower() >= 0);
        CHECK(power(x, n).upper() == doctest::Approx(std::pow(2.0, n)));
    }
    for (const unsigned n : {1u, 3u, 5u}) CHECK(power(Interval(-2.0, -1.0), n).upper() < 0);
    CHECK(power(3.0, 5) == 243);
    CHECK(power(Wide(0.5), 0).contains(1.0));
}

TEST_CASE("polynomial: coefficients that are no doubles are enclosed as tightly as the arithmetic allows") {
    // x^2 y - sqrt(3) y + 1/2.
    const Polynomial<2> p{{{1.0, {2, 1}}, {-sqrt(Wide(3.0)), {0, 1}}, {0.5, {0, 0}}}};
    CHECK(p.degree() == 3);
    const Wide wide = p(WideBox<2>{Wide(2.0), Wide(0.25)});
    const Wide exact = Wide(1.5) - sqrt(Wide(3.0)) * Wide(0.25);
    CHECK((wide - exact).contains(0.0));
    CHECK(wide.radius_exponent() < -300);
    const Interval narrow = p(IntervalBox<2>{Interval(2.0), Interval(0.25)});
    CHECK(is_subset(wide.enclosure(), narrow));
    CHECK(narrow.radius() < 2e-15);
    CHECK(p(Point<2>{2.0, 0.25}) == doctest::Approx(wide.approximation()));
    const auto jet = differentiate(PolynomialSystem<1, 2>{{p}}, Point<2>{2.0, 0.25});
    CHECK(jet[0].gradient[0] == doctest::Approx(1.0));
    CHECK(jet[0].gradient[1] == doctest::Approx(4.0 - std::sqrt(3.0)));
}

TEST_CASE("box: intersection, hull and overlap are those of closed sets") {
    const IntervalBox<2> a{Interval(0, 1), Interval(0, 1)}, b{Interval(1, 2), Interval(-1, 0)},
        c{Interval(1.5, 2), Interval(0, 1)};
    REQUIRE(intersection(a, b));
    CHECK(contains(*intersection(a, b), Point<2>{1, 0}));
    CHECK(width(*intersection(a, b)) < 1e-300);
    CHECK(overlap(a, b));
    CHECK_FALSE(intersection(a, c));
    CHECK_FALSE(overlap(a, c));
    CHECK(is_subset(a, hull(a, c)));
    CHECK(is_subset(c, hull(a, c)));
    CHECK_FALSE(is_subset(hull(a, c), a));
    CHECK(contains(a, mid(a)));
    const WideBox<2> third{Wide(1.0) / Wide(3.0), Wide(2.0)};
    CHECK(is_subset(third, converted<Wide>(converted<Interval>(third))));
}

}  // namespace vcell::jet_test
