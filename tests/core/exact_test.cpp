#include <doctest/doctest.h>

#include <array>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../test_support.hpp"
#include "hostile.hpp"

namespace vcell::exact_test {
using Integer = boost::multiprecision::cpp_int;
using Rational = boost::multiprecision::cpp_rational;

namespace {

/// The same number as an Exact, built from the numerator's 32-bit digits and the power of two below.
Exact to_exact(const Rational& r) {
    const Integer n = abs(numerator(r)), d = denominator(r);
    REQUIRE(msb(d) == lsb(d));
    std::vector<std::uint32_t> digits;
    export_bits(n, std::back_inserter(digits), 32);
    Exact value;
    for (const std::uint32_t digit : digits) value = value * Exact(0x1p32) + Exact(digit);
    for (auto power = msb(d); power > 0; power -= std::min(power, 1000u)) {
        value *= Exact(std::ldexp(1.0, -static_cast<int>(std::min(power, 1000u))));
    }
    return numerator(r) < 0 ? -value : value;
}

Sign sign_of_rational(const Rational& r) { return static_cast<Sign>(r.sign()); }

/// `i` encloses r and nothing smaller does.
void check_tightest(Interval i, const Rational& r) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    REQUIRE(i.lower() != inf);
    REQUIRE(i.upper() != -inf);
    CHECK((i.lower() == -inf || Rational(i.lower()) <= r));
    CHECK((i.upper() == inf || Rational(i.upper()) >= r));
    if (i.lower() != i.upper()) {
        CHECK(std::nextafter(i.lower(), inf) == i.upper());
        CHECK((i.lower() == -inf || Rational(i.lower()) < r));
        CHECK((i.upper() == inf || Rational(i.upper()) > r));
    }
}

}  // namespace

TEST_CASE("Exact: every finite double is itself") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 20'000; ++i) {
        const double v = hostile_double(rng);
        CAPTURE(v);
        const Interval e = Exact(v).enclosure();
        CHECK(e.lower() == v);
        CHECK(e.upper() == v);
        CHECK(Exact(v).sign() == sign_of(v));
    }
}

TEST_CASE("Exact: sums, differences and products agree with rationals") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 300; ++i) {
        // A pool of numbers, each combined from earlier ones.
        std::vector<Exact> exact;
        std::vector<Rational> rational;
        for (int k = 0; k < 5; ++k) {
            const double v = hostile_double(rng);
            exact.emplace_back(v);
            rational.emplace_back(v);
        }
        for (int k = 0; k < 8; ++k) {
            const auto a = rng() % exact.size(), b = rng() % exact.size();
            switch (rng() % 3) {
                case 0:
                    exact.push_back(exact[a] + exact[b]);
                    rational.push_back(rational[a] + rational[b]);
                    break;
                case 1:
                    exact.push_back(exact[a] - exact[b]);
                    rational.push_back(rational[a] - rational[b]);
                    break;
                default: exact.push_back(exact[a] * exact[b]); rational.push_back(rational[a] * rational[b]);
            }
            CHECK(exact.back() == to_exact(rational.back()));
            CHECK(exact.back().sign() == sign_of_rational(rational.back()));
            CHECK((exact[a] < exact[b]) == (rational[a] < rational[b]));
            CHECK((exact[a] == exact[b]) == (rational[a] == rational[b]));
            check_tightest(exact.back().enclosure(), rational.back());
        }
    }
}

TEST_CASE("Exact: the laws of a commutative ring hold") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 3'000; ++i) {
        const Exact a(hostile_double(rng)), b(hostile_double(rng)), c(hostile_double(rng));
        CHECK(a + b == b + a);
        CHECK(a * b == b * a);
        CHECK((a + b) + c == a + (b + c));
        CHECK((a * b) * c == a * (b * c));
        CHECK(a * (b + c) == a * b + a * c);
        CHECK((a - a).sign() == Sign::Zero);
        CHECK((a + -a).sign() == Sign::Zero);
        CHECK(a - b == -(b - a));
        CHECK(a * Exact(1.0) == a);
        CHECK((a * Exact(0.0)).sign() == Sign::Zero);
        Exact d = a;
        d += b;
        d -= c;
        d *= b;
        CHECK(d == (a + b - c) * b);
    }
}

TEST_CASE("Exact: one ulp makes a difference, however large the rest") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 3'000; ++i) {
        const double v = hostile_double(rng);
        const double next = std::nextafter(v, 0.0);
        if (v == 0) continue;
        const Exact large(std::ldexp(1.0, 1000));
        CHECK(large + Exact(v) != large + Exact(next));
        CHECK((large + Exact(std::abs(v)) > large + Exact(std::abs(next))));
    }
}

TEST_CASE("Exact: enclosures of values beyond the doubles are honest") {
    const Exact huge = Exact(std::numeric_limits<double>::max()) * Exact(4.0);
    CHECK(huge.enclosure().lower() == std::numeric_limits<double>::max());
    CHECK(std::isinf(huge.enclosure().upper()));
    CHECK(std::isinf((-huge).enclosure().lower()));
    const Exact tiny = Exact(std::numeric_limits<double>::denorm_min()) * Exact(0.25);
    CHECK(tiny.enclosure().lower() == 0);
    CHECK(tiny.enclosure().upper() == std::numeric_limits<double>::denorm_min());
    CHECK(tiny.sign() == Sign::Positive);
    CHECK(huge.scaled(-2) == Exact(std::numeric_limits<double>::max()));
    CHECK(tiny.scaled(2) == Exact(std::numeric_limits<double>::denorm_min()));
    CHECK(huge.exponent() == 1025);
    CHECK(tiny.exponent() == -1076);
    CHECK(Exact(-0.75).exponent() == -1);
}

TEST_CASE("Exact: square root bounds hold and are as narrow as asked") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 500; ++i) {
        Exact x(std::abs(hostile_double(rng)));
        if (rng() % 2) x *= Exact(std::abs(hostile_double(rng)));
        const int bits = 10 + static_cast<int>(rng() % 300);
        const auto [lo, hi] = x.sqrt_bounds(bits);
        CHECK(lo.sign() != Sign::Negative);
        CHECK(lo * lo <= x);
        CHECK(hi * hi >= x);
        CHECK((hi - lo).scaled(bits) <= hi);
    }
}

TEST_CASE("Exact: square roots of squares are exact") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 500; ++i) {
        const Exact r(std::abs(hostile_double(rng)));
        const auto [lo, hi] = (r * r).sqrt_bounds(20);
        CHECK(lo == r);
        CHECK(hi == r);
    }
}

TEST_CASE("Exact: a common factor is left out, and nothing else") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 200; ++i) {
        const double factor = std::abs(hostile_double(rng));
        std::array<Exact, 4> values;
        for (Exact& v : values) v = Exact(factor) * Exact(static_cast<double>(rng() % 7) - 3);
        const std::array before = values;
        divide_by_common_factor(values);
        for (std::size_t j = 0; j < 4; ++j) {
            CHECK(values[j].sign() == before[j].sign());
            for (std::size_t k = 0; k < 4; ++k) CHECK(values[j] * before[k] == values[k] * before[j]);
            CHECK(values[j] <= Exact(3.0));
            CHECK(values[j] >= Exact(-3.0));
        }
    }
}

}  // namespace vcell::exact_test
