/// Multiprecision intervals with outward rounding: the third rung of the ladder, for curves that leave
/// the quadratic extensions of Q, where no exact number can answer.
///
/// The interface is that of Interval, so that a formula written once runs on both rungs. Bounds are
/// binary floating-point numbers of `Bits` bits. Each operation is rounded to nearest, hence off by at
/// most u |fl(x)|, u = 2^-Bits [Higham02, Thm. 2.2]; its bounds are then moved outwards by 4u |fl(x)|,
/// which also pays for the rounding of that correction. Magnitudes are kept within
/// 2^(+-exponent_limit), far inside the range of the number type: what is smaller is enclosed from
/// zero, what is larger up to infinity, and a computed zero is an exact one.
#pragma once

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <climits>
#include <cmath>
#include <limits>
#include <optional>

#include "interval.hpp"
#include "sign.hpp"

namespace vcell {

template <int Bits>
class WideInterval {
public:
    using Float = boost::multiprecision::number<
        boost::multiprecision::cpp_bin_float<Bits, boost::multiprecision::digit_base_2>,
        boost::multiprecision::et_off>;
    static constexpr int bits = Bits;
    static constexpr int exponent_limit = 1 << 24;

    WideInterval() = default;
    /// Exact; NaN is the whole line.
    WideInterval(double value) : WideInterval(value, value) {}  // NOLINT: a number is an interval
    /// Exact. Pre: lo <= hi.
    WideInterval(double lo, double hi) : WideInterval(Float(lo), Float(hi)) {}
    WideInterval(const Interval& i) : WideInterval(i.lower(), i.upper()) {}  // NOLINT: widens the type
    /// Pre: lo <= hi.
    WideInterval(Float lo, Float hi) : lo_(std::move(lo)), hi_(std::move(hi)) {
        if (isnan(lo_) || isnan(hi_)) *this = whole();
    }
    /// value +- radius, outward.
    static WideInterval ball(const WideInterval& value, double radius) {
        return value + WideInterval(-radius, radius);
    }
    static WideInterval whole() { return {-infinity(), infinity()}; }

    const Float& lower() const { return lo_; }
    const Float& upper() const { return hi_; }
    /// A point within, for bounded intervals.
    WideInterval mid() const {
        Float m = ldexp(Float(lo_ + hi_), -1);
        m = std::clamp(m, lo_, hi_);
        return {m, m};
    }
    /// The double nearest to the middle, or next to it.
    double approximation() const { return mid().lo_.template convert_to<double>(); }
    /// The doubles around the interval; the tightest ones.
    Interval enclosure() const { return {double_below(lo_), -double_below(Float(-hi_))}; }
    bool contains(double v) const { return lo_ <= v && v <= hi_; }
    bool contains(const WideInterval& other) const { return lo_ <= other.lo_ && other.hi_ <= hi_; }

    /// Every member is certainly smaller than 2^magnitude_exponent() in magnitude; INT_MIN for zero,
    /// INT_MAX when unbounded.
    int magnitude_exponent() const { return std::max(exponent_above(lo_), exponent_above(hi_)); }
    /// Half the width is certainly smaller than 2^radius_exponent(); INT_MIN for a point.
    int radius_exponent() const {
        const int e = exponent_above(up(hi_ - lo_));
        return e == INT_MIN || e == INT_MAX ? e : e - 1;
    }

    /// The sign shared by all members; nothing when the interval cannot tell.
    std::optional<Sign> sign() const {
        if (lo_ > 0) return Sign::Positive;
        if (hi_ < 0) return Sign::Negative;
        if (lo_ == 0 && hi_ == 0) return Sign::Zero;
        return std::nullopt;
    }

    friend WideInterval operator-(const WideInterval& a) { return {Float(-a.hi_), Float(-a.lo_)}; }
    friend WideInterval operator+(const WideInterval& a, const WideInterval& b) {
        return {down(a.lo_ + b.lo_), up(a.hi_ + b.hi_)};
    }
    friend WideInterval operator-(const WideInterval& a, const WideInterval& b) {
        return {down(a.lo_ - b.hi_), up(a.hi_ - b.lo_)};
    }
    friend WideInterval operator*(const WideInterval& a, const WideInterval& b) {
        if (a.lo_ == a.hi_) return scaled(b, a.lo_);
        if (b.lo_ == b.hi_) return scaled(a, b.lo_);
        return from_candidates(a.lo_ * b.lo_, a.lo_ * b.hi_, a.hi_ * b.lo_, a.hi_ * b.hi_);
    }
    friend WideInterval operator*(double s, const WideInterval& a) { return scaled(a, Float(s)); }
    /// The whole line when b contains zero.
    friend WideInterval operator/(const WideInterval& a, const WideInterval& b) {
        if (b.lo_ <= 0 && b.hi_ >= 0) return whole();
        if (b.lo_ == b.hi_) {
            const Float p = a.lo_ / b.lo_, q = a.hi_ / b.lo_;
            return from_candidates(p, q, p, q);
        }
        return from_candidates(a.lo_ / b.lo_, a.lo_ / b.hi_, a.hi_ / b.lo_, a.hi_ / b.hi_);
    }
    WideInterval& operator+=(const WideInterval& o) { return *this = *this + o; }
    WideInterval& operator-=(const WideInterval& o) { return *this = *this - o; }
    WideInterval& operator*=(const WideInterval& o) { return *this = *this * o; }

    /// Tighter than a * a: never negative.
    friend WideInterval square(const WideInterval& a) {
        const Float l = abs(a.lo_), h = abs(a.hi_);
        const Float& m = std::max(l, h);
        if (a.lo_ <= 0 && a.hi_ >= 0) return {Float(0), up(m * m)};
        const Float& n = std::min(l, h);
        return {std::max(Float(0), down(n * n)), up(m * m)};
    }
    /// Square root of the non-negative part. Pre: a.upper() >= 0.
    friend WideInterval sqrt(const WideInterval& a) {
        const Float lo = a.lo_ > 0 ? down(root(a.lo_)) : Float(0);
        return {std::max(Float(0), lo), up(root(a.hi_))};
    }
    friend WideInterval hull(const WideInterval& a, const WideInterval& b) {
        return {std::min(a.lo_, b.lo_), std::max(a.hi_, b.hi_)};
    }

private:
    static Float infinity() { return std::numeric_limits<Float>::infinity(); }
    // Within 1.6 u: Newton's method for y = 1 / sqrt(m), x = m 2^e, doubles the digits of a double until half
    // of all are known. With r = m y, y (m - r^2) / 2 brings the others; there only the roundings of r^2 and
    // of the sum count.
    static Float root(const Float& x) {
        if (x == 0 || isinf(x)) return x;
        const int e = exponent_above(x) & ~1;
        const Float m = ldexp(x, -e);
        Float y = 1 / std::sqrt(m.template convert_to<double>());
        for (int known = 50; known < Bits / 2 + 8; known = 2 * known - 2)
            y += ldexp(Float(y * (1 - m * y * y)), -1);
        const Float r = m * y;
        return ldexp(Float(r + ldexp(Float(y * (m - r * r)), -1)), e / 2);
    }

    // Bounds are zero or of magnitude 2^(+-exponent_limit) at most, give or take one rounding. So no
    // operation on them leaves the exponent range (about 2^(+-2^30)), and it yields zero only when its
    // exact result is zero.
    static Float down(const Float& x) { return -up(Float(-x)); }
    static Float up(const Float& x) {
        if (isnan(x)) return infinity();
        if (x == 0) return x;
        if (isinf(x)) return x > 0 ? x : -power(exponent_limit);
        const int e = exponent_above(x);
        if (e > exponent_limit) return x > 0 ? infinity() : -power(exponent_limit);
        if (e < -exponent_limit) return power(-exponent_limit);
        return x + ldexp(Float(abs(x)), 2 - Bits);
    }
    static Float power(int exponent) { return ldexp(Float(1), exponent); }

    // e with |x| < 2^e.
    static int exponent_above(const Float& x) {
        if (x == 0) return INT_MIN;
        if (isinf(x)) return INT_MAX;
        return static_cast<int>(x.backend().exponent()) + 1;
    }

    static WideInterval scaled(const WideInterval& a, const Float& factor) {
        const Float p = a.lo_ * factor, q = a.hi_ * factor;
        return from_candidates(p, q, p, q);
    }
    static WideInterval from_candidates(const Float& p, const Float& q, const Float& r, const Float& s) {
        if (isnan(p) || isnan(q) || isnan(r) || isnan(s)) return whole();
        return {down(std::min(std::min(p, q), std::min(r, s))), up(std::max(std::max(p, q), std::max(r, s)))};
    }

    // The conversion to double is only a guess: comparing back is exact.
    static double double_below(const Float& x) {
        if (isinf(x)) return x > 0 ? std::numeric_limits<double>::max() : -HUGE_VAL;
        double d = x.template convert_to<double>();
        while (Float(d) > x) d = std::nextafter(d, -HUGE_VAL);
        for (double next = std::nextafter(d, HUGE_VAL); !(Float(next) > x);
             next = std::nextafter(next, HUGE_VAL))
            d = next;
        return d;
    }

    Float lo_ = 0;
    Float hi_ = 0;
};

/// The precision of the ladder's third rung: coincidences closer than 2^-200 of the scene are assumed.
using Wide = WideInterval<320>;

}  // namespace vcell
