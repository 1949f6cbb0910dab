#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>

#include "../../core/numbers/wide.hpp"
#include "../test_support.hpp"
#include "hostile.hpp"

namespace vcell::wide_test {
using Rational = boost::multiprecision::cpp_rational;
using Integer = boost::multiprecision::cpp_int;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double largest = std::numeric_limits<double>::max();
constexpr double tiniest = std::numeric_limits<double>::denorm_min();

Rational power_of_two(int e) {
    return e >= 0 ? Rational(Integer(1) << e) : Rational(Integer(1), Integer(1) << -e);
}

// A finite bound, exactly.
Rational exactly(const Wide::Float& x) {
    if (x == 0) return 0;
    int e = 0;
    const Wide::Float fraction = frexp(x, &e);
    const auto mantissa = ldexp(fraction, Wide::bits).convert_to<Integer>();
    return Rational(mantissa) * power_of_two(e - Wide::bits);
}

bool encloses(const Wide& i, const Rational& lo, const Rational& hi) {
    return exactly(i.lower()) <= lo && hi <= exactly(i.upper());
}

/// Encloses [lo, hi], and no bound is farther away than 2^(4 - bits) of itself.
void check_tight(const Wide& i, const Rational& lo, const Rational& hi) {
    CHECK(encloses(i, lo, hi));
    const Rational relative = power_of_two(4 - Wide::bits);
    CHECK(lo - exactly(i.lower()) <= abs(lo) * relative);
    CHECK(exactly(i.upper()) - hi <= abs(hi) * relative);
}

// Bounds that fill the mantissa, from sums and products of hostile doubles.
Wide hostile_wide(std::mt19937_64& rng) {
    const auto point = [&] {
        Wide v = Wide(hostile_double(rng));
        for (auto n = rng() % 3; n > 0; --n)
            v = rng() % 2 ? v + Wide(hostile_double(rng)) : v * Wide(random_double(rng, 40));
        return v;
    };
    const Wide a = point();
    switch (rng() % 3) {
        case 0: return a.mid();
        case 1: return a;
        default: return hull(a, point());
    }
}

std::array<Rational, 2> bounds(const Wide& i) { return {exactly(i.lower()), exactly(i.upper())}; }

std::array<Rational, 2> range(std::initializer_list<Rational> candidates) {
    return {std::min(candidates), std::max(candidates)};
}

}  // namespace

TEST_CASE("wide interval: the four operations enclose the exact range, tightly") {
    std::mt19937_64 rng(test_seed());
    int divided = 0;
    for (int i = 0; i < long_rounds(1'000); ++i) {
        const Wide a = hostile_wide(rng), b = hostile_wide(rng);
        INFO("a = ", a.lower(), " .. ", a.upper(), " b = ", b.lower(), " .. ", b.upper());
        const auto [al, ah] = bounds(a);
        const auto [bl, bh] = bounds(b);
        check_tight(a + b, al + bl, ah + bh);
        check_tight(a - b, al - bh, ah - bl);
        const auto [pl, ph] = range({al * bl, al * bh, ah * bl, ah * bh});
        check_tight(a * b, pl, ph);
        if (b.contains(0.0)) {
            CHECK((a / b).upper() == inf);
            CHECK((a / b).lower() == -inf);
        } else {
            const auto [ql, qh] = range({al / bl, al / bh, ah / bl, ah / bh});
            check_tight(a / b, ql, qh);
            ++divided;
        }
    }
    CHECK(divided > long_rounds(200));
}

TEST_CASE("wide interval: squares and square roots enclose the exact range, never negative") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(1'000); ++i) {
        Wide a = hostile_wide(rng);
        INFO("a = ", a.lower(), " .. ", a.upper());
        const auto [al, ah] = bounds(a);
        const Wide s = square(a);
        CHECK(s.lower() >= 0);
        const auto [lo, hi] = range({al * al, ah * ah});
        check_tight(s, a.contains(0.0) ? Rational(0) : lo, hi);

        if (a.upper() < 0) a = -a;
        const auto [least, most] = bounds(a);
        const Wide r = sqrt(a);
        CHECK(r.lower() >= 0);
        // Bounds of a root are judged by their squares.
        check_tight(square(r), std::max(Rational(0), least), most);
        const auto [rl, rh] = bounds(r);
        CHECK(rl * rl <= std::max(Rational(0), least));
        CHECK(rh * rh >= most);
    }
}

TEST_CASE("wide interval: zero is exact in every operation") {
    const Wide zero(0.0), third = Wide(1.0) / Wide(3.0);
    for (const Wide& v :
         {zero + zero, zero * third, third.mid() - third.mid(), square(zero), sqrt(zero), zero / third})
        CHECK(v.sign() == Sign::Zero);
    CHECK_FALSE((third - third).sign());
}

TEST_CASE("wide interval: endless squaring under- and overflows without losing the value") {
    Wide small(0.5), large(2.0), negative(-2.0);
    for (int i = 0; i < 40; ++i) {
        small = square(small);
        large = square(large);
        negative = negative * large;
    }
    CHECK(small.lower() == 0);
    CHECK(small.upper() > 0);
    CHECK(small.magnitude_exponent() <= -Wide::exponent_limit + 1);
    CHECK(large.lower() > 0);
    CHECK(large.upper() == inf);
    CHECK(large.sign() == Sign::Positive);
    CHECK(negative.sign() == Sign::Negative);
    CHECK(large.magnitude_exponent() == INT_MAX);
    CHECK((Wide(1.0) / small).sign() == std::nullopt);
    CHECK((small * large).contains(1.0));
    CHECK((large - large).contains(-1e300));
    CHECK(sqrt(large).upper() == inf);
}

TEST_CASE("wide interval: invalid operations give the whole line") {
    const Wide unbounded(1.0, inf), zero(0.0), broken(std::numeric_limits<double>::quiet_NaN());
    for (const Wide& i : {unbounded * zero, unbounded / unbounded, broken + zero, zero - broken,
                          broken * broken, zero / broken, Wide::whole() - Wide::whole(), zero / zero}) {
        CHECK(i.lower() == -inf);
        CHECK(i.upper() == inf);
        CHECK_FALSE(i.sign());
    }
}

TEST_CASE("wide interval: the double enclosure is the tightest one") {
    std::mt19937_64 rng(test_seed());
    const auto check = [](const Wide& a) {
        INFO("a = ", a.lower(), " .. ", a.upper());
        const Interval e = a.enclosure();
        CHECK(a.lower() >= e.lower());
        CHECK(a.upper() <= e.upper());
        CHECK(a.lower() < std::nextafter(e.lower(), inf));
        CHECK(a.upper() > std::nextafter(e.upper(), -inf));
    };
    for (int i = 0; i < long_rounds(1'000); ++i) check(hostile_wide(rng));
    for (const double edge : {largest, tiniest, 0.0, DBL_MIN})
        for (const double sign : {-1.0, 1.0}) {
            check(Wide(sign * edge));
            check(Wide(sign * edge) * Wide(1 + 0x1p-52));
            check(Wide(sign * edge) * Wide(0.5));
        }
    const double value = hostile_double(rng);
    CHECK(Wide(value).enclosure().lower() == value);
    CHECK(Wide(value).enclosure().upper() == value);
    CHECK(Wide::whole().enclosure().upper() == inf);
}

TEST_CASE("wide interval: mid lies within, exponents bound what they name") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(1'000); ++i) {
        const Wide a = hostile_wide(rng);
        INFO("a = ", a.lower(), " .. ", a.upper());
        CHECK(a.contains(a.mid()));
        CHECK(a.mid().lower() == a.mid().upper());
        const auto [lo, hi] = bounds(a);
        const auto below = [](const Rational& v, int e) {
            return e == INT_MIN ? v == 0 : v < power_of_two(e);
        };
        CHECK(below(std::max(abs(lo), abs(hi)), a.magnitude_exponent()));
        CHECK(below((hi - lo) / 2, a.radius_exponent()));
    }
    CHECK(Wide(1.0).magnitude_exponent() == 1);
    CHECK(Wide(0x1p-201).magnitude_exponent() == -200);
    CHECK(Wide(3.0).radius_exponent() == INT_MIN);
    const double third = (Wide(1.0) / Wide(3.0)).approximation();
    CHECK(third == 1.0 / 3.0);
}

}  // namespace vcell::wide_test
