#include <doctest/doctest.h>

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <utility>

#include "../../core/numbers/exact.hpp"
#include "../test_support.hpp"
#include "hostile.hpp"

namespace vcell::one_root_test {

namespace {

using Reference =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<300>, boost::multiprecision::et_off>;

/// a + b sqrt(c) by its doubles, in both arithmetics.
struct Number {
    double a, b, c;

    OneRoot exact() const { return {Exact(a), Exact(b), Exact(c)}; }
    Reference value() const { return a + b * sqrt(Reference(c)); }
    Reference scale() const { return abs(Reference(a)) + abs(Reference(b)) * sqrt(Reference(c)); }
};

/// The sign of a value computed to 300 digits from terms of the given size. A non-zero difference of two
/// numbers a + b sqrt(c), taken relative to its terms, has three conjugates of at most 1 and a norm that
/// is a multiple of 2^-848 for 53-bit mantissas of equal exponents: it is above 1e-256. The tests keep
/// the exponents within 2^20, so that 1e-280 is far below every non-zero value that occurs.
Sign reference_sign(const Reference& value, const Reference& scale) {
    if (abs(value) <= scale * Reference("1e-280")) return Sign::Zero;
    return value > 0 ? Sign::Positive : Sign::Negative;
}

Number random_number(std::mt19937_64& rng) {
    Number n{random_double(rng, 5), random_double(rng, 5), std::abs(random_double(rng, 5))};
    if (rng() % 8 == 0) n.a = 0;
    if (rng() % 8 == 0) n.b = 0;
    if (rng() % 8 == 0) n.c = 0;
    return n;
}

double short_double(std::mt19937_64& rng) { return static_cast<double>(1 + rng() % 1000) / 16; }

/// Zero exactly (c is a square), or as close to zero as a double a can bring it.
Number near_zero(std::mt19937_64& rng) {
    Number n;
    n.b = rng() % 2 ? short_double(rng) : -short_double(rng);
    if (rng() % 2) {
        const double root = short_double(rng);
        n.c = root * root;
        n.a = -n.b * root;
    } else {
        n.c = std::abs(random_double(rng, 5));
        n.a = -n.b * std::sqrt(n.c);
    }
    for (auto steps = rng() % 3; steps > 0; --steps) n.a = std::nextafter(n.a, rng() % 2 ? 1e9 : -1e9);
    return n;
}

void check_sign(const Number& n) {
    INFO("n.a = ", n.a, " n.b = ", n.b, " n.c = ", n.c);
    CHECK(sign(n.exact()) == reference_sign(n.value(), n.scale()));
}

void check_compare(const Number& p, double p_den, const Number& q, double q_den) {
    INFO("p.a = ", p.a, " p.b = ", p.b, " p.c = ", p.c, " p_den = ", p_den);
    INFO("q.a = ", q.a, " q.b = ", q.b, " q.c = ", q.c, " q_den = ", q_den);
    const Sign expected =
        reference_sign(p.value() / p_den - q.value() / q_den, p.scale() / p_den + q.scale() / q_den);
    CHECK(compare(p.exact(), Exact(p_den), q.exact(), Exact(q_den)) == expected);
    CHECK(compare(q.exact(), Exact(q_den), p.exact(), Exact(p_den)) == -expected);
}

void check_enclosure(const Number& n, double den) {
    INFO("n.a = ", n.a, " n.b = ", n.b, " n.c = ", n.c, " den = ", den);
    const Interval i = enclosure(n.exact(), Exact(den));
    if (reference_sign(n.value(), n.scale()) == Sign::Zero) {
        CHECK(i.sign() == Sign::Zero);
        return;
    }
    const Reference value = n.value() / den;
    CHECK(i.lower() <= value);
    CHECK(i.upper() >= value);
    CHECK(i.upper() - i.lower() <= 16 * std::numeric_limits<double>::epsilon() * i.magnitude());
}

}  // namespace

TEST_CASE("OneRoot: sign agrees with 300 digits") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 4'000; ++i) check_sign(random_number(rng));
}

TEST_CASE("OneRoot: sign is right at zero and one ulp from it") {
    std::mt19937_64 rng(test_seed());
    int zeros = 0;
    for (int i = 0; i < 4'000; ++i) {
        const Number n = near_zero(rng);
        check_sign(n);
        zeros += sign(n.exact()) == Sign::Zero;
    }
    CHECK(zeros > 500);
    CHECK(sign(OneRoot{-3.0, 1.5, 4.0}) == Sign::Zero);
    CHECK(sign(OneRoot{std::nextafter(-3.0, 0.0), 1.5, 4.0}) == Sign::Positive);
    CHECK(sign(OneRoot{-3.0, 1.5, std::nextafter(4.0, 0.0)}) == Sign::Negative);
}

TEST_CASE("OneRoot: compare agrees with 300 digits across fields") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(2'000); ++i) {
        check_compare(random_number(rng), std::abs(random_double(rng, 5)), random_number(rng),
                      std::abs(random_double(rng, 5)));
    }
}

TEST_CASE("OneRoot: compare tells equal numbers of different spelling from those one ulp off") {
    std::mt19937_64 rng(test_seed());
    int equal = 0;
    for (int i = 0; i < long_rounds(3'000); ++i) {
        Number p{rng() % 2 ? short_double(rng) : -short_double(rng),
                 rng() % 2 ? short_double(rng) : -short_double(rng), short_double(rng)};
        if (rng() % 5 == 0) p.a = -p.b * std::sqrt(p.c);
        // The same number: numerator and denominator times k, the root pulled in by 2^-m.
        const double k = static_cast<double>(1 + rng() % 50),
                     m = std::ldexp(1.0, static_cast<int>(rng() % 5) - 2);
        Number q{p.a * k, p.b * k * m, p.c / (m * m)};
        double den = k;
        switch (rng() % 6) {
            case 0: q.a = std::nextafter(q.a, 1e9); break;
            case 1: q.b = std::nextafter(q.b, -1e9); break;
            case 2: q.c = std::nextafter(q.c, 1e9); break;
            case 3: den = std::nextafter(den, 1e9); break;
            default: break;
        }
        check_compare(p, 1.0, q, den);
        equal += compare(p.exact(), Exact(1.0), q.exact(), Exact(den)) == Sign::Zero;
    }
    CHECK(equal > long_rounds(500));
}

TEST_CASE("OneRoot: compare agrees where the two roots nearly cancel") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(2'000); ++i) {
        // q.a is p - q.b sqrt(q.c), rounded: p and q differ in their last digits only.
        const Number p = random_number(rng);
        Number q = random_number(rng);
        q.a = static_cast<double>(p.value() - q.b * sqrt(Reference(q.c)));
        check_compare(p, 1.0, q, 1.0);
    }
}

TEST_CASE("OneRoot: arithmetic stays in the field") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 1'000; ++i) {
        const Number p = random_number(rng);
        Number q = random_number(rng);
        q.c = p.c;
        const double s = random_double(rng, 5);
        const auto same = [&](const OneRoot& exact, const Reference& value) {
            // As intervals around both: exact.a, exact.b need not be doubles.
            const Interval e = enclosure(exact, Exact(1.0));
            const Reference slack = Reference("1e-270") * (1 + abs(value)) * 1e20;
            CHECK(e.lower() <= value + slack);
            CHECK(e.upper() >= value - slack);
        };
        same(p.exact() + q.exact(), p.value() + q.value());
        same(p.exact() - q.exact(), p.value() - q.value());
        same(p.exact() * q.exact(), p.value() * q.value());
        same(Exact(s) * p.exact(), s * p.value());
        same(p.exact() + Exact(s), p.value() + s);
    }
}

TEST_CASE("OneRoot: enclosure holds and stays narrow under cancellation") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 1'000; ++i) {
        check_enclosure(random_number(rng), random_double(rng, 5));
        check_enclosure(near_zero(rng), random_double(rng, 5));
    }
}

TEST_CASE("OneRoot: enclosure survives numerators and denominators beyond the doubles") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 300; ++i) {
        const Number n = near_zero(rng);
        const double den = random_double(rng, 5);
        const Interval expected = enclosure(n.exact(), Exact(den));
        for (const long power : {-5000L, 5000L}) {
            const OneRoot scaled = Exact(1.0).scaled(power) * n.exact();
            const Interval found = enclosure(scaled, Exact(den).scaled(power));
            CHECK(found.lower() == expected.lower());
            CHECK(found.upper() == expected.upper());
        }
    }
}

}  // namespace vcell::one_root_test
