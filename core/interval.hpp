/// Double intervals with outward rounding: the second rung of the ladder.
///
/// Rounding modes are not switched (fragile under an optimiser, slow in a pipeline). Each operation
/// is computed to nearest and its result moved outwards by one unit in the last place at least:
/// for round-to-nearest, |fl(x) - x| <= u |fl(x)| + s with u = 2^-53 and s = 2^-1075, so
/// fl(x) -+ (2u |fl(x)| + s') with s' = 2^-1074 encloses x even after the rounding of the
/// correction itself [Higham02, Thm. 2.2]. Overflow gives infinite bounds, invalid operations the
/// whole line: an interval never lies.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "sign.hpp"

namespace vcell {

class Interval {
public:
    constexpr Interval() = default;
    constexpr Interval(double value) : lo_(value), hi_(value) {}  // NOLINT: a number is an interval
    /// Pre: lo <= hi.
    constexpr Interval(double lo, double hi) : lo_(lo), hi_(hi) {}
    /// value +- radius, outward.
    static Interval ball(double value, double radius) {
        return {down(value - radius), up(value + radius)};
    }
    static constexpr Interval whole() {
        return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    }

    double lower() const { return lo_; }
    double upper() const { return hi_; }
    /// A point within, for bounded intervals.
    double mid() const { return std::midpoint(lo_, hi_); }
    /// Upper bound of the distance of a member from mid(): of two adjacent doubles mid() is one, and half the
    /// width would miss the other.
    double radius() const { return up(std::max(hi_ - mid(), mid() - lo_)); }
    /// Upper bound of the width.
    double width() const { return up(hi_ - lo_); }
    double magnitude() const { return std::max(std::abs(lo_), std::abs(hi_)); }
    bool contains(double v) const { return lo_ <= v && v <= hi_; }

    /// The sign shared by all members; nothing when the interval cannot tell.
    std::optional<Sign> sign() const {
        if (lo_ > 0) return Sign::Positive;
        if (hi_ < 0) return Sign::Negative;
        if (lo_ == 0 && hi_ == 0) return Sign::Zero;
        return std::nullopt;
    }

    friend Interval operator-(Interval a) { return {-a.hi_, -a.lo_}; }
    friend Interval operator+(Interval a, Interval b) {
        return {down(a.lo_ + b.lo_), up(a.hi_ + b.hi_)};
    }
    friend Interval operator-(Interval a, Interval b) {
        return {down(a.lo_ - b.hi_), up(a.hi_ - b.lo_)};
    }
    friend Interval operator*(Interval a, Interval b) {
        const double p = a.lo_ * b.lo_, q = a.lo_ * b.hi_, r = a.hi_ * b.lo_, s = a.hi_ * b.hi_;
        return from_candidates(p, q, r, s);
    }
    /// A number as a factor takes two products instead of four.
    friend Interval operator*(double s, Interval a) {
        return s < 0 ? Interval(down(s * a.hi_), up(s * a.lo_)) : Interval(down(s * a.lo_), up(s * a.hi_));
    }
    /// The whole line when b contains zero.
    friend Interval operator/(Interval a, Interval b) {
        if (b.lo_ <= 0 && b.hi_ >= 0) return whole();
        const double p = a.lo_ / b.lo_, q = a.lo_ / b.hi_, r = a.hi_ / b.lo_, s = a.hi_ / b.hi_;
        return from_candidates(p, q, r, s);
    }
    Interval& operator+=(Interval o) { return *this = *this + o; }
    Interval& operator-=(Interval o) { return *this = *this - o; }
    Interval& operator*=(Interval o) { return *this = *this * o; }

    /// Tighter than a * a: never negative.
    friend Interval square(Interval a) {
        const double m = a.magnitude();
        if (a.lo_ <= 0 && a.hi_ >= 0) return {0.0, up(m * m)};
        const double n = std::min(std::abs(a.lo_), std::abs(a.hi_));
        return {std::max(0.0, down(n * n)), up(m * m)};
    }
    /// Square root of the non-negative part. Pre: a.upper() >= 0.
    friend Interval sqrt(Interval a) {
        const double lo = a.lo_ > 0 ? down(std::sqrt(a.lo_)) : 0.0;
        return {std::max(0.0, lo), a.hi_ == 0 ? 0.0 : up(std::sqrt(a.hi_))};
    }
    friend Interval hull(Interval a, Interval b) {
        return {std::min(a.lo_, b.lo_), std::max(a.hi_, b.hi_)};
    }

    /// A double not above / not below the exact value that rounds to x; NaN opens the bound.
    static double down(double x) {
        return x != x ? -std::numeric_limits<double>::infinity() : clamp_inf(x - slack(x), x, -1);
    }
    static double up(double x) {
        return x != x ? std::numeric_limits<double>::infinity() : clamp_inf(x + slack(x), x, 1);
    }

private:
    static double slack(double x) {
        return std::numeric_limits<double>::epsilon() * std::abs(x) +
               std::numeric_limits<double>::denorm_min();
    }
    // An overflowed result is +-inf: the exact value lies between the largest double and it.
    static double clamp_inf(double moved, double x, int direction) {
        if (!std::isinf(x)) return moved;
        const double largest = std::numeric_limits<double>::max();
        if (direction < 0) return x > 0 ? largest : x;
        return x < 0 ? -largest : x;
    }
    static Interval from_candidates(double p, double q, double r, double s) {
        const double sum = (p + q) + (r + s);
        if (std::abs(sum) <= std::numeric_limits<double>::max()) {  // all four are finite
            const double lo = std::min(std::min(p, q), std::min(r, s)), hi = std::max(std::max(p, q), std::max(r, s));
            return {lo - slack(lo), hi + slack(hi)};
        }
        if (p != p || q != q || r != r || s != s) return whole();
        return {down(std::min(std::min(p, q), std::min(r, s))), up(std::max(std::max(p, q), std::max(r, s)))};
    }

    double lo_ = 0;
    double hi_ = 0;
};

}  // namespace vcell
