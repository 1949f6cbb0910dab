#include "../../core/numbers/compensated.hpp"

#include <doctest/doctest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "../../core/numbers/exact.hpp"
#include "test_support.hpp"

namespace vcell::compensated_test {

namespace {

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

// |value - exact| <= 1.01 u |exact|
bool is_close(double value, const Exact& exact) {
    const Exact error = Exact(value) - exact, bound = Exact(1.01 * u) * exact;
    return error * error <= bound * bound;
}

}  // namespace

TEST_CASE("halves: their products are exact and they add up") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 1000; ++i) {
        const Halves x(std::ldexp(unit(rng), static_cast<int>(rng() % 200) - 100)), y(unit(rng));
        CHECK(x.high + x.low == x.value);
        for (const double p : {x.high, x.low})
            for (const double q : {y.high, y.low}) CHECK(Exact(p * q) == Exact(p) * q);
    }
}

TEST_CASE("difference: high and low add up to it exactly") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 1000; ++i) {
        const double a = unit(rng), b = std::ldexp(unit(rng), static_cast<int>(rng() % 120) - 60);
        const Difference d(a, b);
        CHECK(Exact(d.high.value) + d.low == Exact(a) - b);
        CHECK(std::abs(d.low) <= u * std::abs(d.high.value));
    }
}

TEST_CASE("compensated sum: within 1.01 u, or no answer where too much cancels") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    int answered = 0, refused = 0;
    for (int i = 0; i < 4000; ++i) {
        // Eight terms: products, squares of differences, differences; the last cancels the others down to a
        // part of 2^-bits.
        const int bits = static_cast<int>(rng() % 80);
        CompensatedSum<> sum;
        Exact exact;
        for (int k = 0; k < 5; ++k) {
            const double x = unit(rng), a = unit(rng), b = unit(rng);
            const Difference d(a, b);
            if (k % 3 == 0) {
                sum.add(Halves(x), d);
                exact += Exact(x) * (Exact(a) - b);
            } else if (k % 3 == 1) {
                sum.add_square(k == 1 ? 1 : -1, d);
                exact += (k == 1 ? 1.0 : -1.0) * (Exact(a) - b) * (Exact(a) - b);
            } else {
                sum.add(Halves<>(-1), d);
                exact -= Exact(a) - b;
            }
        }
        const double rest = std::ldexp(unit(rng), -bits), head = exact.enclosure().mid(),
                     tail = (exact - head).enclosure().mid();
        for (const double x : {-head, -tail, rest}) {
            sum.add(Halves<>(1), Halves<>(x));
            exact += x;
        }
        const double factor = std::round(0x1p50 * unit(rng));
        const auto value = sum.value(), product = sum.times(Halves(factor)).value();
        if (value) CHECK(is_close(*value, exact));
        if (product) CHECK(is_close(*product, factor * exact));
        (value ? answered : refused) += 1;
        if (bits < 30 && std::abs(rest) > std::ldexp(0.5, -bits)) CHECK(value.has_value());
    }
    CHECK(answered > 1000);
    CHECK(refused > 1000);
    CompensatedSum<> zero;
    zero.add(Halves<>(0), Halves<>(3));
    CHECK(zero.value() == 0.0);
}

TEST_CASE("compensated sum: several at once are as one by one") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 200; ++i) {
        CompensatedSum<Eigen::Array4d> sums;
        std::array<CompensatedSum<>, 4> each;
        for (int k = 0; k < 4; ++k) {
            const Eigen::Array4d x(unit(rng), unit(rng), unit(rng), unit(rng));
            const Difference d(unit(rng), unit(rng));
            sums.add(Halves(x), d);
            for (int j = 0; j < 4; ++j) each[j].add(Halves<>(x[j]), d);
        }
        const auto values = sums.times(Halves<>(3)).value();
        REQUIRE(values);
        for (int j = 0; j < 4; ++j) CHECK((*values)[j] == each[j].times(Halves<>(3)).value());
    }
    // One that cancels spoils the answer.
    CompensatedSum<Eigen::Array4d> sums;
    sums.add(Halves<Eigen::Array4d>(Eigen::Array4d(1, 2, 3, 4)), Halves<>(1));
    sums.add(Halves<Eigen::Array4d>(Eigen::Array4d(1, 2, -3, 4)), Halves<>(1));
    CHECK(!sums.value());
}

}  // namespace vcell::compensated_test
