/// Real intervals by midpoint and radius, in arithmetic that rounds to nearest [Rump99]: a product takes one
/// product of midpoints, where one of bounds takes four. Wide intervals are better kept by their bounds
/// (core/numbers/interval.hpp).
///
/// Midpoints are rounded once by each operation, by at most 2^-53 of themselves or, where they are subnormal,
/// half the least double. Each radius grows by 2^-52 of the midpoint and by 2^-50 of itself, which is more
/// than that and what the few operations can have lost that gave the radius [Higham02, Thm. 2.2].
#pragma once

#include <cmath>
#include <limits>

#include "../../core/numbers/interval.hpp"

namespace vcell::check {

class MidRad {
public:
    constexpr MidRad() = default;
    constexpr MidRad(double value) : mid_(value) {}  // NOLINT: a number is an interval
    MidRad(const Interval& i)                        // NOLINT: so is an interval
        : mid_(i.mid()), radius_(i.lower() == i.upper() ? 0 : i.radius()) {}
    static MidRad ball(double mid, double radius) { return {mid, radius}; }
    static MidRad whole() { return {0, std::numeric_limits<double>::infinity()}; }

    double mid() const { return mid_; }
    double radius() const { return radius_; }
    double lower() const { return Interval::down(mid_ - radius_); }
    double upper() const { return Interval::up(mid_ + radius_); }
    Interval enclosure() const {
        if (radius_ == 0) return mid_;
        return radius_ < HUGE_VAL ? Interval(lower(), upper()) : Interval::whole();
    }
    /// Upper bound of all |x|.
    double magnitude() const { return (std::abs(mid_) + radius_) * up; }

    friend MidRad operator-(const MidRad& a) { return {-a.mid_, a.radius_}; }
    friend MidRad operator+(const MidRad& a, const MidRad& b) {
        return rounded(a.mid_ + b.mid_, a.radius_ + b.radius_);
    }
    friend MidRad operator-(const MidRad& a, const MidRad& b) {
        return rounded(a.mid_ - b.mid_, a.radius_ + b.radius_);
    }
    friend MidRad operator*(const MidRad& a, const MidRad& b) {
        return rounded(a.mid_ * b.mid_,
                       std::abs(a.mid_) * b.radius_ + a.radius_ * (std::abs(b.mid_) + b.radius_));
    }
    friend MidRad operator*(double s, const MidRad& a) {
        return rounded(s * a.mid_, std::abs(s) * a.radius_);
    }
    /// The whole line when b contains zero.
    friend MidRad operator/(const MidRad& a, const MidRad& b) {
        const double rest = std::abs(b.mid_) - b.radius_ * up - slack * std::abs(b.mid_);
        if (!(rest > 0)) return whole();
        const double q = a.mid_ / b.mid_;
        // What the product may lose below normal numbers is divided, too.
        constexpr double lost = 2 * std::numeric_limits<double>::denorm_min();
        return rounded(q, (a.radius_ + std::abs(q) * b.radius_ + lost) / rest);
    }
    MidRad& operator+=(const MidRad& o) { return *this = *this + o; }

    /// Halves are exact, or off by half the least double.
    friend MidRad mean(const MidRad& a, const MidRad& b) {
        return rounded(0.5 * (a.mid_ + b.mid_), 0.5 * (a.radius_ + b.radius_));
    }
    friend MidRad square(const MidRad& a) {
        return rounded(a.mid_ * a.mid_, a.radius_ * (2 * std::abs(a.mid_) + a.radius_));
    }
    /// Square root of the non-negative part: |sqrt(x) - sqrt(m)| <= |x - m| / sqrt(m).
    friend MidRad sqrt(const MidRad& a) {
        if (a.mid_ > a.radius_) {
            const double root = std::sqrt(a.mid_);
            return rounded(root, a.radius_ / root);
        }
        const double most = std::sqrt(std::max(0.0, a.mid_ + a.radius_) * up) * up;
        return a.radius_ < HUGE_VAL ? rounded(0.5 * most, 0.5 * most) : whole();
    }

private:
    static constexpr double slack = 0x1p-52, up = 1 + 0x1p-50, least = std::numeric_limits<double>::min();

    constexpr MidRad(double mid, double radius) : mid_(mid), radius_(radius) {}
    static MidRad rounded(double mid, double radius) {
        return {mid, radius * up + (slack * std::abs(mid) + least)};
    }

    double mid_ = 0, radius_ = 0;
};

}  // namespace vcell::check
