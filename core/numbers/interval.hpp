/// Double intervals with outward rounding: the second rung of the ladder.
///
/// Rounding modes are not switched (fragile under an optimiser, slow in a pipeline). Each operation
/// is computed to nearest and its result moved outwards by one unit in the last place at least:
/// for round-to-nearest, |fl(x) - x| <= u |fl(x)| + s with u = 2^-53 and s = 2^-1075, so
/// fl(x) -+ (2u |fl(x)| + s') with s' = 2^-1074 encloses x even after the rounding of the
/// correction itself [Higham02, Thm. 2.2]. Overflow gives infinite bounds, invalid operations the
/// whole line: an interval never lies.
///
/// Kept are -lower and upper, side by side: both are rounded upwards by the same few instructions, two at a
/// time where the machine can, and the pair stays in one register. (Kept as two numbers they were written
/// apart and read together, for which a processor waits longer than a product takes.)
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

/// Two doubles, worked on at once where the machine can.
class DoublePair {
public:
#if defined(__SSE2__)
    constexpr DoublePair(double first, double second) : v_{first, second} {}
    static DoublePair both(double x) { return _mm_set1_pd(x); }
    double first() const { return _mm_cvtsd_f64(v_); }
    double second() const { return _mm_cvtsd_f64(_mm_unpackhi_pd(v_, v_)); }
    DoublePair swapped() const { return _mm_shuffle_pd(v_, v_, 1); }

    friend DoublePair operator+(DoublePair a, DoublePair b) { return _mm_add_pd(a.v_, b.v_); }
    friend DoublePair operator*(DoublePair a, DoublePair b) { return _mm_mul_pd(a.v_, b.v_); }
    friend DoublePair operator/(DoublePair a, DoublePair b) { return _mm_div_pd(a.v_, b.v_); }
    friend DoublePair operator-(DoublePair a) { return _mm_xor_pd(a.v_, _mm_set1_pd(-0.0)); }
    friend DoublePair abs(DoublePair a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a.v_); }
    friend DoublePair negated_first(DoublePair a) { return _mm_xor_pd(a.v_, _mm_setr_pd(-0.0, 0.0)); }
    friend DoublePair max(DoublePair a, DoublePair b) { return _mm_max_pd(a.v_, b.v_); }
    friend DoublePair firsts(DoublePair a, DoublePair b) { return _mm_unpacklo_pd(a.v_, b.v_); }
    friend DoublePair seconds(DoublePair a, DoublePair b) { return _mm_unpackhi_pd(a.v_, b.v_); }
    /// Neither infinite nor none.
    friend bool is_finite(DoublePair a) {
        const __m128d largest = _mm_set1_pd(std::numeric_limits<double>::max());
        return _mm_movemask_pd(_mm_cmple_pd(abs(a).v_, largest)) == 3;
    }

private:
    DoublePair(__m128d v) : v_(v) {}  // NOLINT: a register is the pair

    __m128d v_;
#else
    constexpr DoublePair(double first, double second) : first_(first), second_(second) {}
    static DoublePair both(double x) { return {x, x}; }
    double first() const { return first_; }
    double second() const { return second_; }
    DoublePair swapped() const { return {second_, first_}; }

    friend DoublePair operator+(DoublePair a, DoublePair b) {
        return {a.first_ + b.first_, a.second_ + b.second_};
    }
    friend DoublePair operator*(DoublePair a, DoublePair b) {
        return {a.first_ * b.first_, a.second_ * b.second_};
    }
    friend DoublePair operator/(DoublePair a, DoublePair b) {
        return {a.first_ / b.first_, a.second_ / b.second_};
    }
    friend DoublePair operator-(DoublePair a) { return {-a.first_, -a.second_}; }
    friend DoublePair abs(DoublePair a) { return {std::abs(a.first_), std::abs(a.second_)}; }
    friend DoublePair negated_first(DoublePair a) { return {-a.first_, a.second_}; }
    friend DoublePair max(DoublePair a, DoublePair b) {
        return {std::max(a.first_, b.first_), std::max(a.second_, b.second_)};
    }
    friend DoublePair firsts(DoublePair a, DoublePair b) { return {a.first_, b.first_}; }
    friend DoublePair seconds(DoublePair a, DoublePair b) { return {a.second_, b.second_}; }
    /// Neither infinite nor none.
    friend bool is_finite(DoublePair a) {
        constexpr double largest = std::numeric_limits<double>::max();
        return std::abs(a.first_) <= largest && std::abs(a.second_) <= largest;
    }

private:
    double first_, second_;
#endif
};

class Interval {
public:
    constexpr Interval() = default;
    constexpr Interval(double value) : ends_(-value, value) {}  // NOLINT: a number is an interval
    /// Pre: lo <= hi.
    constexpr Interval(double lo, double hi) : ends_(-lo, hi) {}
    /// value +- radius, outward.
    static Interval ball(double value, double radius) { return {down(value - radius), up(value + radius)}; }
    static constexpr Interval whole() {
        return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    }

    double lower() const { return -ends_.first(); }
    double upper() const { return ends_.second(); }
    /// A point within, for bounded intervals.
    double mid() const { return std::midpoint(lower(), upper()); }
    /// Upper bound of the distance of a member from mid(): of two adjacent doubles mid() is one, and half the
    /// width would miss the other.
    double radius() const { return up(std::max(upper() - mid(), mid() - lower())); }
    /// Upper bound of the width.
    double width() const { return up(upper() - lower()); }
    double magnitude() const { return std::max(std::abs(lower()), std::abs(upper())); }
    bool contains(double v) const { return lower() <= v && v <= upper(); }

    /// The sign shared by all members; nothing when the interval cannot tell.
    std::optional<Sign> sign() const {
        if (lower() > 0) return Sign::Positive;
        if (upper() < 0) return Sign::Negative;
        if (lower() == 0 && upper() == 0) return Sign::Zero;
        return std::nullopt;
    }

    friend Interval operator-(Interval a) { return Interval(a.ends_.swapped()); }
    friend Interval operator+(Interval a, Interval b) { return outward(a.ends_ + b.ends_); }
    friend Interval operator-(Interval a, Interval b) { return outward(a.ends_ + b.ends_.swapped()); }
    friend Interval operator*(Interval a, Interval b) {
        const DoublePair ends = negated_first(b.ends_);
        return from_candidates(DoublePair::both(a.lower()) * ends, DoublePair::both(a.upper()) * ends);
    }
    /// A number as a factor takes two products instead of four.
    friend Interval operator*(double s, Interval a) {
        return outward(DoublePair::both(std::abs(s)) * (s < 0 ? a.ends_.swapped() : a.ends_));
    }
    /// The whole line when b contains zero.
    friend Interval operator/(Interval a, Interval b) {
        if (b.lower() <= 0 && b.upper() >= 0) return whole();
        const DoublePair ends = negated_first(b.ends_);
        return from_candidates(DoublePair::both(a.lower()) / ends, DoublePair::both(a.upper()) / ends);
    }
    Interval& operator+=(Interval o) { return *this = *this + o; }
    Interval& operator-=(Interval o) { return *this = *this - o; }
    Interval& operator*=(Interval o) { return *this = *this * o; }

    /// Tighter than a * a: never negative.
    friend Interval square(Interval a) {
        const double m = a.magnitude();
        if (a.lower() <= 0 && a.upper() >= 0) return {0.0, up(m * m)};
        const double n = std::min(std::abs(a.lower()), std::abs(a.upper()));
        return {std::max(0.0, down(n * n)), up(m * m)};
    }
    /// Square root of the non-negative part. Pre: a.upper() >= 0.
    friend Interval sqrt(Interval a) {
        const double lo = a.lower() > 0 ? down(std::sqrt(a.lower())) : 0.0;
        return {std::max(0.0, lo), a.upper() == 0 ? 0.0 : up(std::sqrt(a.upper()))};
    }
    friend Interval hull(Interval a, Interval b) { return Interval(max(a.ends_, b.ends_)); }

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
    explicit Interval(DoublePair ends) : ends_(ends) {}

    static Interval outward(DoublePair ends) {
        if (!is_finite(ends)) [[unlikely]]
            return {down(-ends.first()), up(ends.second())};
        return moved_up(ends);
    }
    // Where neither end is infinite or none.
    static Interval moved_up(DoublePair ends) {
        const DoublePair slack = DoublePair::both(std::numeric_limits<double>::epsilon()) * abs(ends) +
                                 DoublePair::both(std::numeric_limits<double>::denorm_min());
        return Interval(ends + slack);
    }
    // The range of the four.
    static Interval from_candidates(DoublePair pq, DoublePair rs) {
        if (!is_finite(pq + rs)) [[unlikely]]
            return from_any_candidates(pq.first(), pq.second(), rs.first(), rs.second());
        // Sums are finite: so are all four.
        const DoublePair high = max(pq, rs), low = max(-pq, -rs);
        return moved_up(max(firsts(low, high), seconds(low, high)));
    }
    static Interval from_any_candidates(double p, double q, double r, double s) {
        if (p != p || q != q || r != r || s != s) return whole();
        return {down(std::min(std::min(p, q), std::min(r, s))), up(std::max(std::max(p, q), std::max(r, s)))};
    }

    DoublePair ends_{-0.0, 0.0};  // -lower, upper
};

}  // namespace vcell
