/// Multiprecision intervals with outward rounding: the third rung of the ladder, for curves that leave
/// the quadratic extensions of Q, where no exact number can answer.
///
/// The interface is that of Interval, so that a formula written once runs on both rungs. Bounds are
/// binary floating-point numbers of `bits` bits. Each operation is rounded to nearest, hence off by at
/// most u |fl(x)|, u = 2^-bits [Higham02, Thm. 2.2]; its bounds are then moved outwards by 4u |fl(x)|,
/// which also pays for the rounding of that correction. Magnitudes are kept within
/// 2^(+-exponent_limit), far inside the range of the number type: what is smaller is enclosed from
/// zero, what is larger up to infinity, and a computed zero is an exact one.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <optional>
#include <utility>

#include "interval.hpp"
#include "sign.hpp"

namespace vcell {

/// Operations are not inline: each takes hundreds of cycles, and a compiler that sees them in every file that
/// does arithmetic is a tenth of a build.
class Wide {
public:
    /// The precision of the ladder's third rung: coincidences closer than 2^-200 of the scene are assumed.
    static constexpr int bits = 320;
    using Float = boost::multiprecision::number<
        boost::multiprecision::cpp_bin_float<bits, boost::multiprecision::digit_base_2>,
        boost::multiprecision::et_off>;
    static constexpr int exponent_limit = 1 << 24;

    Wide();
    /// Exact; NaN is the whole line.
    Wide(double value) : Wide(value, value) {}  // NOLINT: a number is an interval
    /// Exact. Pre: lo <= hi.
    Wide(double lo, double hi);
    Wide(const Interval& i) : Wide(i.lower(), i.upper()) {}  // NOLINT: widens the type
    /// Pre: lo <= hi.
    Wide(Float lo, Float hi);
    /// value +- radius, outward.
    static Wide ball(const Wide& value, double radius) { return value + Wide(-radius, radius); }
    static Wide whole();

    const Float& lower() const { return lo_; }
    const Float& upper() const { return hi_; }
    /// A point within, for bounded intervals.
    Wide mid() const;
    /// The double nearest to the middle, or next to it.
    double approximation() const;
    /// The doubles around the interval; the tightest ones.
    Interval enclosure() const;
    bool contains(double v) const;
    bool contains(const Wide& other) const;

    /// Every member is certainly smaller than 2^magnitude_exponent() in magnitude; INT_MIN for zero,
    /// INT_MAX when unbounded.
    int magnitude_exponent() const;
    /// Half the width is certainly smaller than 2^radius_exponent(); INT_MIN for a point.
    int radius_exponent() const;

    /// The sign shared by all members; nothing when the interval cannot tell.
    std::optional<Sign> sign() const;

    friend Wide operator-(const Wide& a);
    friend Wide operator+(const Wide& a, const Wide& b);
    friend Wide operator-(const Wide& a, const Wide& b);
    friend Wide operator*(const Wide& a, const Wide& b);
    friend Wide operator*(double s, const Wide& a);
    /// The whole line when b contains zero.
    friend Wide operator/(const Wide& a, const Wide& b);
    Wide& operator+=(const Wide& o) { return *this = *this + o; }
    Wide& operator-=(const Wide& o) { return *this = *this - o; }
    Wide& operator*=(const Wide& o) { return *this = *this * o; }

    /// Tighter than a * a: never negative.
    friend Wide square(const Wide& a) { return a.squared(); }
    /// Square root of the non-negative part. Pre: a.upper() >= 0.
    friend Wide sqrt(const Wide& a) { return a.square_root(); }
    friend Wide hull(const Wide& a, const Wide& b) { return a.hull_with(b); }

private:
    Wide squared() const;
    Wide square_root() const;
    Wide hull_with(const Wide& other) const;

    Float lo_;
    Float hi_;
};

}  // namespace vcell
