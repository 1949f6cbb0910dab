/// What Traced says of rounding in doubles, against doubles and enclosures of the true values.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "../../io/check/face_terms.hpp"
#include "../../io/check/quadrature.hpp"
#include "../../io/check/traced.hpp"
#include "../test_support.hpp"

namespace vcell::check {
namespace {

/// Sums that cancel, quotients and roots, with a constant that is no double.
template <class T>
std::array<T, 4> expressions(const T& x, double a, double b) {
    const MidRad third = MidRad(1.0) / 3.0;
    const T y = x * x - T(a) + T(third), z = T(b) / (x + T(3.0)), w = sqrt(T(2.0) + x * y);
    return {y - z, square(w) - x * y, (w - z) / (T(2.0) + x), -w + 0.1 * (y * z)};
}

/// The antiderivative of face_terms.hpp with the midpoints of its constants, in more digits.
long double precise_antiderivative(const Revolved& r, long double b) {
    const long double b1 = r.b1.mid(), B = r.B.mid(), E = r.E.mid();
    const long double s = std::sqrt(E + 2 * B * b), s1 = std::sqrt(E + 2 * B * b1), sum = s + s1;
    const long double first = (s * (b1 + b) - 2 * B * b * b / sum) / (2 * b * b1 * b * b1);
    const long double second = B / (2 * E) * (s - 2 * B * b / sum) / (b * b1);
    const long double ratio = (s * s1 + E) / (sum * (E * (b + b1) + 2 * B * b * b1));
    const long double x = std::sqrt(E) * (b1 - b) * ratio;
    return first + second - B * B / E * ratio * (x == 0 ? 1 : std::atanh(x) / x);
}

}  // namespace

TEST_CASE("artanh_ratio: plain values are off by no more than the antiderivative's error counts with") {
    std::mt19937_64 rng(test_seed());
    for (const double most : {0x1p-9, 0x1p-8, 0.0625, 0.25, 0.4, 0.75, 0.999})
        for (int k = 0; k < 1000; ++k) {
            std::uniform_real_distribution<double> number(-most, most);
            const auto x = Approximate::of([&](std::size_t) { return number(rng); });
            const Approximate value = artanh_ratio(x);
            for (std::size_t lane = 0; lane < Approximate::lanes; ++lane) {
                CAPTURE(x[lane]);
                if (x[lane] == 0) continue;
                const long double precise = std::atanh(static_cast<long double>(x[lane])) / x[lane];
                CHECK(std::abs(value[lane] - precise) <= 0x1p-48 * precise);
            }
        }
}

TEST_CASE("traced: bounds what plain doubles are off by, all over a range") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    double tightest = HUGE_VAL;
    int known = 0;
    for (int k = 0; k < 300; ++k) {
        const double a = unit(rng), b = unit(rng), middle = 0.5 * unit(rng), half = 0.5 * std::abs(unit(rng));
        const auto traced = expressions(Traced(Disc(middle, half), 0), a, b);
        for (int n = 0; n < 20; ++n) {
            const double x = middle + 0.99 * half * unit(rng);
            const auto plain = expressions(Approximate(x), a, b);
            const auto truth = expressions(MidRad(x), a, b);
            for (std::size_t i = 0; i < traced.size(); ++i) {
                if (!(traced[i].error() < HUGE_VAL)) continue;
                ++known;
                CHECK(std::abs(plain[i][0] - truth[i].mid()) <= traced[i].error() + truth[i].radius());
                CHECK(std::abs(truth[i].mid() - traced[i].range().center()) <=
                      traced[i].range().radius() + truth[i].radius());
                tightest = std::min(tightest, traced[i].error());
            }
        }
    }
    CHECK(known > 10'000);
    CHECK(tightest < 0x1p-48);
    CHECK(tightest > 0x1p-54);  // a bound of nothing would be none
}

TEST_CASE("traced: the bound of a face's area holds at every place of a disc") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    double closest = 0, tightest = HUGE_VAL;
    int known = 0;
    for (int k = 0; k < 3000; ++k) {
        const double A = 1.25 + 0.75 * unit(rng), B = 0.9 * A * unit(rng), E = (A - B) * (A + B);
        const Revolved r({0.0, 0.0, 1.0}, 1.0, A, B, E, false);
        const double middle = A * (0.5 + 0.4 * unit(rng)) + B, half = 0.1 * std::abs(middle * unit(rng));
        const double error = std::abs(middle) * (k % 2 ? 0x1p-50 : 0x1p-40);
        const double bound = error_of_antiderivative(r, Disc(middle, half), error);
        if (!(bound < HUGE_VAL)) continue;
        ++known;
        tightest = std::min(tightest, bound);
        for (int n = 0; n < 10; ++n) {
            const double b = middle + half * unit(rng), off = error * unit(rng);
            const double plain = antiderivative(r, Approximate(b + off))[0];
            const double actual = static_cast<double>(std::abs(plain - precise_antiderivative(r, b)));
            CHECK(actual <= bound);
            closest = std::max(closest, actual / bound);
        }
    }
    CHECK(known > 1000);
    CHECK(closest > 0x1p-7);  // and is not so large that anything would hold
    CHECK(tightest < 0x1p-40);
}

TEST_CASE("traced: errors of what goes in are carried along") {
    const Traced x(Disc(2, 0.5), 0x1p-20), y(Disc(1, 0.25), 0x1p-21);
    // At ends of the ranges, with errors at theirs.
    for (const double s : {1.5, 2.5})
        for (const double t : {0.75, 1.25})
            for (const double e : {-0x1p-20, 0x1p-20})
                for (const double f : {-0x1p-21, 0x1p-21}) {
                    CHECK(std::abs((s + e) * (t + f) - s * t) <= (x * y).error());
                    CHECK(std::abs((s + e) / (t + f) - s / t) <= (x / y).error());
                    CHECK(std::abs((s + e) - (t + f) - (s - t)) <= (x - y).error());
                    CHECK(std::abs(std::sqrt(s + e) - std::sqrt(s)) <= sqrt(x).error());
                }
    CHECK((x * y).error() < 0x1p-17);
    CHECK_FALSE((x / Traced(Disc(1, 1), 0)).error() < HUGE_VAL);
}

TEST_CASE("integrate: encloses integrals whose values cancel to their rounding") {
    // (x + s)^2 - x^2 - 2 x s is s^2: over [-1, 1] 2 / 3. With x of 2^20 doubles are off by 2^-12 or so.
    for (const double x : {1.0, 0x1p10, 0x1p20}) {
        std::array<Interval, 1> sum{};
        Effort effort{16};
        const bool is_complete = integrate<1>(
            [&]<class T>(const T& s) {
                return std::array<T, 1>{square(T(x) + s) - T(x) * T(x) - 2.0 * (T(x) * s)};
            },
            -1, 1, {0x1p-40 * x * x}, sum, effort);
        CHECK(is_complete);
        CHECK(sum[0].lower() <= 2.0 / 3);
        CHECK(sum[0].upper() >= 2.0 / 3);
        CHECK(sum[0].width() <= 0x1p-35 * x * x);
    }
}

TEST_CASE(
    "integrate: encloses integrals over rectangles, with poles beside them and a constant that is known badly") {
    // The product of s^2 / ((s - p)^2 + r^2) and t^2 / ((t - q)^2 + w^2), of which the integrals are known.
    // The constant's error counts as rounding: plain doubles do, or sums are enclosed node by node, by what
    // may be missing.
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(-1.2, 1.2), logarithm(-2, 2);
    const auto integral = [](long double p, long double r, long double a, long double b) {
        const auto primitive = [&](long double x) {
            return x + p * std::log((x - p) * (x - p) + r * r) + (p * p - r * r) / r * std::atan((x - p) / r);
        };
        return primitive(b) - primitive(a);
    };
    const double badly = 0x1p-30;
    const MidRad one = MidRad::ball(1, badly);
    for (int k = 0; k < 60; ++k) {
        const double p = place(rng), q = place(rng), r = std::exp2(logarithm(rng)),
                     w = std::exp2(logarithm(rng));
        CAPTURE(p);
        CAPTURE(r);
        CAPTURE(q);
        CAPTURE(w);
        const auto density = [&]<class T>(const T& s) {
            const T along = T(one) * (square(s) / (square(s - T(p)) + T(r) * T(r)));
            return [&, along](const T& t) {
                return std::array<T, 1>{along * (square(t) / (square(t - T(q)) + T(w) * T(w)))};
            };
        };
        const double truth = static_cast<double>(integral(p, r, -1, 1) * integral(q, w, 0, 1));
        for (const double enough : {0x1p-10, 0x1p-30, 0x1p-44}) {
            CAPTURE(enough);
            std::array<Interval, 1> sum{};
            Effort effort{1 << 12};
            CHECK(integrate<1>(density, {-1, 0}, {1, 1}, {enough}, sum, effort));
            for (const double sign : {-1.0, 1.0})
                CHECK(std::abs(sum[0].mid() - truth * (1 + sign * badly)) <=
                      sum[0].radius() + 0x1p-50 * truth);
            CHECK(sum[0].radius() <= 64 * enough + 2 * badly * truth);
        }
    }
}

}  // namespace vcell::check
