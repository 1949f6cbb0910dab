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

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

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
    friend Interval operator+(Interval a, Interval b) { return outward(a.lo_ + b.lo_, a.hi_ + b.hi_); }
    friend Interval operator-(Interval a, Interval b) { return outward(a.lo_ - b.hi_, a.hi_ - b.lo_); }
    friend Interval operator*(Interval a, Interval b) {
        const Bounds both = bounds(b);
        return from_candidates(bounds(a.lo_) * both, bounds(a.hi_) * both);
    }
    /// A number as a factor takes two products instead of four.
    friend Interval operator*(double s, Interval a) {
        return s < 0 ? outward(s * a.hi_, s * a.lo_) : outward(s * a.lo_, s * a.hi_);
    }
    /// The whole line when b contains zero.
    friend Interval operator/(Interval a, Interval b) {
        if (b.lo_ <= 0 && b.hi_ >= 0) return whole();
        const Bounds both = bounds(b);
        return from_candidates(bounds(a.lo_) / both, bounds(a.hi_) / both);
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
    // Both bounds where neither is infinite or none: then their difference is not, or overflows.
    static Interval outward(double lo, double hi) {
        if (std::abs(hi - lo) <= std::numeric_limits<double>::max()) return {lo - slack(lo), hi + slack(hi)};
        return {down(lo), up(hi)};
    }
    static Interval from_any_candidates(double p, double q, double r, double s) {
        if (p != p || q != q || r != r || s != s) return whole();
        return {down(std::min(std::min(p, q), std::min(r, s))), up(std::max(std::max(p, q), std::max(r, s)))};
    }

#if defined(__SSE2__)
    // Two candidates at once.
    using Bounds = __m128d;
    static Bounds bounds(Interval a) { return _mm_set_pd(a.hi_, a.lo_); }
    static Bounds bounds(double a) { return _mm_set1_pd(a); }

    static Interval from_candidates(Bounds pq, Bounds rs) {
        const __m128d minus = _mm_set1_pd(-0.0);
        const __m128d size = _mm_andnot_pd(minus, _mm_add_pd(pq, rs));
        // Sums are finite: so are all four.
        if (_mm_movemask_pd(_mm_cmple_pd(size, _mm_set1_pd(std::numeric_limits<double>::max()))) == 3) {
            const __m128d high = _mm_max_pd(pq, rs), low = _mm_max_pd(_mm_xor_pd(pq, minus), _mm_xor_pd(rs, minus));
            // (-lo, hi)
            const __m128d x = _mm_max_pd(_mm_unpacklo_pd(low, high), _mm_unpackhi_pd(low, high));
            const __m128d slack =
                _mm_add_pd(_mm_mul_pd(_mm_set1_pd(std::numeric_limits<double>::epsilon()), _mm_andnot_pd(minus, x)),
                           _mm_set1_pd(std::numeric_limits<double>::denorm_min()));
            const __m128d moved = _mm_add_pd(x, slack);
            return {-_mm_cvtsd_f64(moved), _mm_cvtsd_f64(_mm_unpackhi_pd(moved, moved))};
        }
        return from_any_candidates(_mm_cvtsd_f64(pq), _mm_cvtsd_f64(_mm_unpackhi_pd(pq, pq)), _mm_cvtsd_f64(rs),
                                   _mm_cvtsd_f64(_mm_unpackhi_pd(rs, rs)));
    }
#else
    struct Bounds {
        double lo, hi;
        friend Bounds operator*(Bounds a, Bounds b) { return {a.lo * b.lo, a.hi * b.hi}; }
        friend Bounds operator/(Bounds a, Bounds b) { return {a.lo / b.lo, a.hi / b.hi}; }
    };
    static Bounds bounds(Interval a) { return {a.lo_, a.hi_}; }
    static Bounds bounds(double a) { return {a, a}; }

    static Interval from_candidates(Bounds pq, Bounds rs) {
        const auto [p, q] = pq;
        const auto [r, s] = rs;
        const double sum = (p + q) + (r + s);
        if (std::abs(sum) <= std::numeric_limits<double>::max()) {  // all four are finite
            const double lo = std::min(std::min(p, q), std::min(r, s)), hi = std::max(std::max(p, q), std::max(r, s));
            return {lo - slack(lo), hi + slack(hi)};
        }
        return from_any_candidates(p, q, r, s);
    }
#endif

    double lo_ = 0;
    double hi_ = 0;
};

}  // namespace vcell
