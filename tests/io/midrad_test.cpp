/// Arithmetic by midpoint and radius, and polynomials with one bound on all errors, against exact numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "../../io/check/forms.hpp"
#include "../../io/check/midrad.hpp"
#include "../core/hostile.hpp"
#include "../test_support.hpp"

namespace vcell::check {
namespace {

using Rational = boost::multiprecision::cpp_rational;

bool holds(const MidRad& x, const Rational& value) {
    if (!(x.radius() < HUGE_VAL)) return true;
    const Rational off = value - Rational(x.mid());
    return (off < 0 ? Rational(-off) : off) <= Rational(x.radius());
}

/// A hostile number, and a few numbers in a ball about it.
struct Sample {
    MidRad ball;
    std::vector<Rational> members;
};
Sample sample(std::mt19937_64& rng) {
    const double mid = hostile_double(rng);
    const double radius = rng() % 3 == 0 ? 0.0 : std::abs(hostile_double(rng));
    return {MidRad::ball(mid, radius),
            {Rational(mid), Rational(mid) + Rational(radius), Rational(mid) - Rational(radius),
             Rational(mid) + Rational(radius) / 3}};
}

}  // namespace

TEST_CASE("midrad: operations enclose the results of all members") {
    std::mt19937_64 rng(test_seed());
    for (int k = 0; k < 300 * rounds(); ++k) {
        const Sample a = sample(rng), b = sample(rng);
        CAPTURE(a.ball.mid());
        CAPTURE(a.ball.radius());
        CAPTURE(b.ball.mid());
        CAPTURE(b.ball.radius());
        const MidRad sum = a.ball + b.ball, difference = a.ball - b.ball, product = a.ball * b.ball,
                     quotient = a.ball / b.ball, squared = square(a.ball), root = sqrt(a.ball),
                     twice = 2.5 * a.ball;
        for (const Rational& x : a.members) {
            CHECK(holds(squared, x * x));
            CHECK(holds(twice, x * Rational(2.5)));
            // r holds the root of x where no member of its ball is too small or too large.
            if (x >= 0 && root.radius() < HUGE_VAL) {
                const Rational lo = Rational(root.mid()) - Rational(root.radius()),
                               hi = Rational(root.mid()) + Rational(root.radius());
                CHECK(hi >= 0);
                CHECK(hi * hi >= x);
                CHECK((lo <= 0 || lo * lo <= x));
            }
            for (const Rational& y : b.members) {
                CHECK(holds(sum, x + y));
                CHECK(holds(difference, x - y));
                CHECK(holds(product, x * y));
                if (y != 0) CHECK(holds(quotient, x / y));
            }
        }
        const Interval i = a.ball.enclosure();
        for (const Rational& x : a.members) {
            CHECK((i.lower() == -HUGE_VAL || Rational(i.lower()) <= x));
            CHECK((i.upper() == HUGE_VAL || Rational(i.upper()) >= x));
        }
    }
}

TEST_CASE("midrad: numbers of ordinary size are known to a few units in the last place") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(1, 2);
    for (int k = 0; k < 1000; ++k) {
        const MidRad a(unit(rng)), b(unit(rng));
        for (const MidRad& x : {a + b, a - b, a * b, a / b, square(a), sqrt(a)})
            CHECK(x.radius() <= 0x1p-51 * std::abs(x.mid()) + 0x1p-1000);
    }
    CHECK(MidRad(3.0).enclosure().width() <= 0x1p-1000);
    CHECK_FALSE((MidRad(1.0) / MidRad::ball(0.5, 0.5)).radius() < HUGE_VAL);
}

TEST_CASE("forms: ranges hold the exact values of what cancels") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const auto& [m, n] : std::vector<std::array<int, 2>>{{2, 2}, {2, 0}, {3, 1}, {9, 3}, {60, 0}})
        for (int k = 0; k < 20; ++k) {
            const double far = std::exp2(20 * unit(rng));
            Form a(m, n), b(m, n);
            std::vector<Rational> exact_a, exact_b;
            for (int i = 0; i <= m; ++i)
                for (int j = 0; j <= n; ++j) {
                    // Known no better than to a ball; the true ones are at its end.
                    const double x = far + unit(rng), y = unit(rng);
                    a.set(i, j, MidRad::ball(x, 0x1p-50 * far));
                    b.set(i, j, y);
                    exact_a.push_back(Rational(x) + Rational(0x1p-50 * far));
                    exact_b.push_back(Rational(y));
                }
            // (a + b)^2 - a^2 - 2 a b at a corner, where Bernstein coefficients are values: b^2.
            const Form rest = square(a + b) - square(a) - MidRad(2.0) * (a * b);
            const Interval range = rest.range();
            for (const std::size_t corner : {std::size_t{0}, exact_b.size() - 1}) {
                const Rational value = exact_b[corner] * exact_b[corner];
                CHECK(Rational(range.lower()) <= value);
                CHECK(Rational(range.upper()) >= value);
            }
            CHECK(range.width() <= 2 + 0x1p-40 * far * far * (m + n));
            // The sum of all its bounds is a bound: what is written as zero holds zero, and is no more exact
            // than it is.
            const Interval zero = (square(a) - a * a).range();
            CHECK(zero.contains(0));
            const Form shifted = a - MidRad(far) * [&] {
                Form one(m, n);
                for (int i = 0; i <= m; ++i)
                    for (int j = 0; j <= n; ++j) one.set(i, j, 1.0);
                return one;
            }();
            for (const std::size_t corner : {std::size_t{0}, exact_a.size() - 1}) {
                CHECK(Rational(shifted.range().lower()) <= exact_a[corner] - Rational(far));
                CHECK(Rational(shifted.range().upper()) >= exact_a[corner] - Rational(far));
            }
        }
}

}  // namespace vcell::check
