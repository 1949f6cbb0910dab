#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>

#include "../../core/numbers/interval.hpp"
#include "../test_support.hpp"
#include "hostile.hpp"

namespace vcell::interval_test {
using Rational = boost::multiprecision::cpp_rational;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double largest = std::numeric_limits<double>::max();
constexpr double tiniest = std::numeric_limits<double>::denorm_min();

bool at_most(double bound, const Rational& exact) {
    return bound == -inf || (bound != inf && Rational(bound) <= exact);
}
bool at_least(double bound, const Rational& exact) {
    return bound == inf || (bound != -inf && Rational(bound) >= exact);
}
bool encloses(Interval i, const Rational& exact) {
    return at_most(i.lower(), exact) && at_least(i.upper(), exact);
}

double steps_up(double v, int n) {
    for (; n > 0; --n) v = std::nextafter(v, inf);
    return v;
}
double steps_down(double v, int n) { return -steps_up(-v, n); }

// A bound moves at most 3.5 units outwards: half by rounding to nearest, less than two by the relative
// correction and one by the absolute one, which counts only among the smallest normal numbers.
constexpr int ulps = 4;

/// Encloses [lo, hi], and with a bound moved inwards by `ulps` doubles would not.
void check_tight(Interval i, const Rational& lo, const Rational& hi) {
    CHECK(at_most(i.lower(), lo));
    CHECK(at_least(i.upper(), hi));
    CHECK_FALSE(at_most(steps_up(i.lower(), ulps), lo));
    CHECK_FALSE(at_least(steps_down(i.upper(), ulps), hi));
}

Interval hostile_interval(std::mt19937_64& rng) {
    const double a = hostile_double(rng);
    double b = hostile_double(rng);
    if (rng() % 3 == 0) b = a;
    if (rng() % 3 == 0) b = std::nextafter(a, largest);
    return {std::min(a, b), std::max(a, b)};
}

std::array<Rational, 2> bounds(Interval i) { return {Rational(i.lower()), Rational(i.upper())}; }

std::array<Rational, 2> range(std::initializer_list<Rational> candidates) {
    return {std::min(candidates), std::max(candidates)};
}

}  // namespace

TEST_CASE("interval: sums and differences enclose the exact range within four ulp") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 5'000; ++i) {
        const Interval a = hostile_interval(rng), b = hostile_interval(rng);
        INFO("a.lower() = ", a.lower(), " a.upper() = ", a.upper(), " b.lower() = ", b.lower(),
             " b.upper() = ", b.upper());
        const auto [al, ah] = bounds(a);
        const auto [bl, bh] = bounds(b);
        check_tight(a + b, al + bl, ah + bh);
        check_tight(a - b, al - bh, ah - bl);
        const Interval negated = -a;
        CHECK(negated.lower() == -a.upper());
        CHECK(negated.upper() == -a.lower());
    }
}

TEST_CASE("interval: products enclose the exact range within four ulp") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 5'000; ++i) {
        const Interval a = hostile_interval(rng), b = hostile_interval(rng);
        INFO("a.lower() = ", a.lower(), " a.upper() = ", a.upper(), " b.lower() = ", b.lower(),
             " b.upper() = ", b.upper());
        const auto [al, ah] = bounds(a);
        const auto [bl, bh] = bounds(b);
        const auto [lo, hi] = range({al * bl, al * bh, ah * bl, ah * bh});
        check_tight(a * b, lo, hi);
    }
}

TEST_CASE("interval: quotients enclose the exact range within four ulp") {
    std::mt19937_64 rng(test_seed());
    int divided = 0;
    for (int i = 0; i < 5'000; ++i) {
        const Interval a = hostile_interval(rng), b = hostile_interval(rng);
        INFO("a.lower() = ", a.lower(), " a.upper() = ", a.upper(), " b.lower() = ", b.lower(),
             " b.upper() = ", b.upper());
        if (b.contains(0.0)) {
            CHECK((a / b).lower() == -inf);
            CHECK((a / b).upper() == inf);
            continue;
        }
        const auto [al, ah] = bounds(a);
        const auto [bl, bh] = bounds(b);
        const auto [lo, hi] = range({al / bl, al / bh, ah / bl, ah / bh});
        check_tight(a / b, lo, hi);
        ++divided;
    }
    CHECK(divided > 1'000);
}

TEST_CASE("interval: squares enclose the exact range, never negative") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 5'000; ++i) {
        const Interval a = hostile_interval(rng);
        INFO("a.lower() = ", a.lower(), " a.upper() = ", a.upper());
        const auto [al, ah] = bounds(a);
        const Interval s = square(a);
        CHECK(s.lower() >= 0);
        const auto [lo, hi] = range({al * al, ah * ah});
        const Rational least = a.contains(0.0) ? Rational(0) : lo;
        CHECK(at_most(s.lower(), least));
        CHECK((a.contains(0.0) || !at_most(steps_up(s.lower(), ulps), least)));
        CHECK(at_least(s.upper(), hi));
        CHECK_FALSE(at_least(steps_down(s.upper(), ulps), hi));
    }
}

TEST_CASE("interval: square roots enclose the exact range within four ulp") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 5'000; ++i) {
        Interval a = hostile_interval(rng);
        if (a.upper() < 0) a = -a;
        INFO("a.lower() = ", a.lower(), " a.upper() = ", a.upper());
        const Interval r = sqrt(a);
        CHECK(r.lower() >= 0);
        // Bounds of a root are judged by their squares.
        const Rational least = a.lower() > 0 ? Rational(a.lower()) : Rational(0);
        const Rational most(a.upper());
        const auto squared = [](double v) { return Rational(v) * Rational(v); };
        CHECK(squared(r.lower()) <= least);
        CHECK(squared(steps_up(r.lower(), ulps)) > least);
        CHECK(squared(r.upper()) >= most);
        if (r.upper() > 0)
            CHECK((squared(steps_down(r.upper(), ulps)) < most || steps_down(r.upper(), ulps) < 0));
    }
    CHECK(sqrt(Interval(-1.0, 4.0)).lower() == 0);
    CHECK(sqrt(Interval(0.0)).upper() == 0);
}

TEST_CASE("interval: overflow opens one bound and keeps the sign") {
    const Interval a(largest);
    for (const Interval i : {a + a, a * a, a / Interval(0.5), square(a), Interval(1.0) / Interval(tiniest)}) {
        CHECK(i.lower() == largest);
        CHECK(i.upper() == inf);
        CHECK(i.sign() == Sign::Positive);
        CHECK((-i).upper() == -largest);
    }
}

TEST_CASE("interval: underflow keeps zero out of no product of non-zeros, in of none") {
    const Interval product = Interval(tiniest) * Interval(tiniest);
    CHECK(encloses(product, Rational(tiniest) * Rational(tiniest)));
    CHECK_FALSE(product.sign());
    CHECK(product.upper() <= 2 * tiniest);
}

TEST_CASE("interval: invalid operations give the whole line") {
    const Interval unbounded(1.0, inf), zero(0.0), broken(not_a_number);
    for (const Interval i :
         {unbounded * zero, unbounded / unbounded, broken + zero, zero - broken, broken * broken,
          zero / broken, Interval::whole() - Interval::whole(), zero / zero}) {
        CHECK(i.lower() == -inf);
        CHECK(i.upper() == inf);
        CHECK_FALSE(i.sign());
    }
    CHECK(sqrt(broken).upper() == inf);
    CHECK(square(broken).upper() == inf);
    CHECK((unbounded - unbounded).lower() == -inf);
}

TEST_CASE("interval: results of unbounded operands still enclose") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 2'000; ++i) {
        const double edge = hostile_double(rng), inner = hostile_double(rng);
        const Interval ray = rng() % 2 ? Interval(edge, inf) : Interval(-inf, edge);
        const double member =
            ray.upper() == inf ? std::max(edge, hostile_double(rng)) : std::min(edge, hostile_double(rng));
        INFO("edge = ", edge, " inner = ", inner, " member = ", member);
        const Rational x(member), y(inner);
        CHECK(encloses(ray + Interval(inner), x + y));
        CHECK(encloses(Interval(inner) - ray, y - x));
        CHECK(encloses(ray * Interval(inner), x * y));
        CHECK(encloses(square(ray), x * x));
        if (inner != 0) CHECK(encloses(ray / Interval(inner), x / y));
        if (member != 0) CHECK(encloses(Interval(inner) / ray, y / x));
    }
}

TEST_CASE("interval: ball, hull, radius, width and mid bound what they name") {
    std::mt19937_64 rng(test_seed());
    const auto check_sizes = [](const Interval& a) {
        const auto [lo, hi] = bounds(a);
        const Rational mid(a.mid());
        CHECK(at_least(a.radius(), hi - mid));
        CHECK(at_least(a.radius(), mid - lo));
        CHECK(at_least(a.width(), hi - lo));
        CHECK(a.contains(a.mid()));
    };
    for (int i = 0; i < 2'000; ++i) {
        const double centre = hostile_double(rng), radius = std::abs(hostile_double(rng));
        INFO("centre = ", centre, " radius = ", radius);
        const Interval b = Interval::ball(centre, radius);
        CHECK(encloses(b, Rational(centre) - Rational(radius)));
        CHECK(encloses(b, Rational(centre) + Rational(radius)));
        const Interval a = hostile_interval(rng);
        check_sizes(a);
        check_sizes(hull(Interval(centre), std::nextafter(centre, 0.0)));
        CHECK(a.magnitude() == std::max(std::abs(a.lower()), std::abs(a.upper())));
        const Interval h = hull(a, b);
        CHECK(h.lower() == std::min(a.lower(), b.lower()));
        CHECK(h.upper() == std::max(a.upper(), b.upper()));
    }
}

TEST_CASE("interval: sign answers only when all members agree") {
    CHECK(Interval(tiniest, 1.0).sign() == Sign::Positive);
    CHECK(Interval(-1.0, -tiniest).sign() == Sign::Negative);
    CHECK(Interval(0.0).sign() == Sign::Zero);
    CHECK(Interval(-0.0, 0.0).sign() == Sign::Zero);
    CHECK_FALSE(Interval(0.0, 1.0).sign());
    CHECK_FALSE(Interval(-1.0, 0.0).sign());
    CHECK_FALSE(Interval(-1.0, 1.0).sign());
}

}  // namespace vcell::interval_test
