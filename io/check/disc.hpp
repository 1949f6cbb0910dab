/// Discs of complex numbers, by centre and radius: bounds of analytic functions on ellipses about real intervals,
/// which is what the remainders of quadrature rules are made of (quadrature.hpp).
///
/// A disc holds all that its operation may give for members of its operands. Centres and radii are rounded to
/// nearest; each radius grows by 2^-48 of itself and of the centre, which is more than the few operations that
/// either took can have lost [Higham02, sec. 2.2]. (Radii are far above subnormal numbers: units are chosen so.)
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "../../core/interval.hpp"

namespace vcell::check {

class Disc {
public:
    constexpr Disc() = default;
    constexpr Disc(double re) : x_(re) {}                                     // NOLINT: a number is a disc
    Disc(Interval re) : x_(re.mid()), radius_(re.lower() == re.upper() ? 0 : re.radius()) {}  // NOLINT: so is an interval
    constexpr Disc(double re, double im, double radius) : x_(re), y_(im), radius_(radius) {}

    double re() const { return x_; }
    double im() const { return y_; }
    double radius() const { return radius_; }
    /// Upper bound of all |z|; infinite or not a number where nothing is known.
    double magnitude() const { return (centre() + radius_) * up; }

    friend Disc operator-(const Disc& a) { return {-a.x_, -a.y_, a.radius_}; }
    friend Disc operator+(const Disc& a, const Disc& b) { return rounded(a.x_ + b.x_, a.y_ + b.y_, a.radius_ + b.radius_); }
    friend Disc operator-(const Disc& a, const Disc& b) { return rounded(a.x_ - b.x_, a.y_ - b.y_, a.radius_ + b.radius_); }
    // The rounding of a centre's component may be relative to its terms: to the product of the sizes.
    friend Disc operator*(const Disc& a, const Disc& b) {
        const double r = a.centre(), s = b.centre();
        return {a.x_ * b.x_ - a.y_ * b.y_, a.x_ * b.y_ + a.y_ * b.x_,
                (r * b.radius_ + s * a.radius_ + a.radius_ * b.radius_) * up + r * s * slack};
    }
    friend Disc operator*(double s, const Disc& a) {
        return rounded(s * a.x_, s * a.y_, std::abs(s) * a.radius_);
    }
    /// 1 / b lies about conj(b) / (|b|^2 - r^2) with radius r / (|b|^2 - r^2). Everything where b may be zero.
    friend Disc operator/(const Disc& a, const Disc& b) {
        const double d = b.x_ * b.x_ + b.y_ * b.y_, r2 = b.radius_ * b.radius_, rest = d * (1 - slack) - r2 * up;
        if (!(rest > 0)) return whole();
        // Where b is small for its radius, the quotient of rounding is that of d to the rest.
        const double grown = 1 + slack * (d / rest);
        return a * Disc(b.x_ / rest, -b.y_ / rest,
                        b.radius_ / rest * grown * up + std::sqrt(d) / rest * (grown - 1) + std::sqrt(d) / rest * slack);
    }
    Disc& operator+=(const Disc& o) { return *this = *this + o; }

    friend Disc square(const Disc& a) { return a * a; }
    /// The root with a positive real part; everything where a may be zero or negative: |sqrt(z) - sqrt(c)| =
    /// |z - c| / |sqrt(z) + sqrt(c)|, of which the denominator is at least sqrt(|c|), both having positive real
    /// parts.
    friend Disc sqrt(const Disc& a) {
        const double size = a.centre();
        const bool is_clear = a.x_ > 0 ? size * (1 - slack) > a.radius_ : std::abs(a.y_) * (1 - slack) > a.radius_;
        if (!is_clear) return whole();
        const double root = std::sqrt(size), u = std::sqrt(0.5 * (size + std::abs(a.x_))), v = std::abs(a.y_) / (2 * u);
        const double sign = a.y_ < 0 ? -1 : 1;
        return {a.x_ >= 0 ? u : v, sign * (a.x_ >= 0 ? v : u), a.radius_ / root * up + root * slack};
    }
    /// A disc that holds both.
    friend Disc hull(const Disc& a, const Disc& b) {
        const double x = 0.5 * (a.x_ + b.x_), y = 0.5 * (a.y_ + b.y_);
        const double dx = 0.5 * (b.x_ - a.x_), dy = 0.5 * (b.y_ - a.y_);
        return rounded(x, y, std::sqrt(dx * dx + dy * dy) + std::max(a.radius_, b.radius_) +
                                 slack * (a.centre() + b.centre()));
    }

    static Disc whole() { return {0, 0, std::numeric_limits<double>::infinity()}; }

private:
    static constexpr double slack = 0x1p-48, up = 1 + slack;

    double centre() const { return std::sqrt(x_ * x_ + y_ * y_); }
    static Disc rounded(double x, double y, double radius) {
        return {x, y, radius * up + (std::abs(x) + std::abs(y)) * slack};
    }

    double x_ = 0, y_ = 0, radius_ = 0;
};

}  // namespace vcell::check
