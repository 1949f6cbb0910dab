/// Discs of complex numbers about real ones, by centre and radius: bounds of analytic functions on ellipses
/// about real intervals, which is what the remainders of quadrature rules are made of (quadrature.hpp). All
/// that is computed there is real on the real axis, so that centres stay real.
///
/// A disc holds all that its operation may give for members of its operands. Centres and radii are rounded to
/// nearest; each radius grows by 2^-48 of itself and of the centre, which is more than the few operations
/// that either took can have lost [Higham02, sec. 2.2]. (Radii are far above subnormal numbers: units are
/// chosen so.)
#pragma once

#include <cmath>
#include <limits>

#include "midrad.hpp"

namespace vcell::check {

class Disc {
public:
    constexpr Disc() = default;
    constexpr Disc(double center) : x_(center) {}                // NOLINT: a number is a disc
    Disc(const MidRad& i) : x_(i.mid()), radius_(i.radius()) {}  // NOLINT: an interval lies in one
    constexpr Disc(double center, double radius) : x_(center), radius_(radius) {}

    double center() const { return x_; }
    double radius() const { return radius_; }
    /// Upper bound of all |z|; infinite or not a number where nothing is known.
    double magnitude() const { return (std::abs(x_) + radius_) * up; }

    friend Disc operator-(const Disc& a) { return {-a.x_, a.radius_}; }
    friend Disc operator+(const Disc& a, const Disc& b) {
        return rounded(a.x_ + b.x_, a.radius_ + b.radius_);
    }
    friend Disc operator-(const Disc& a, const Disc& b) {
        return rounded(a.x_ - b.x_, a.radius_ + b.radius_);
    }
    friend Disc operator*(const Disc& a, const Disc& b) {
        return rounded(a.x_ * b.x_, std::abs(a.x_) * b.radius_ + a.radius_ * (std::abs(b.x_) + b.radius_));
    }
    friend Disc operator*(double s, const Disc& a) { return rounded(s * a.x_, std::abs(s) * a.radius_); }
    /// 1 / b lies about x / (x^2 - r^2) with radius r / (x^2 - r^2). Everything where b may be zero.
    friend Disc operator/(const Disc& a, const Disc& b) {
        const double d = b.x_ * b.x_, rest = d * (1 - slack) - b.radius_ * b.radius_ * up;
        if (!(rest > 0)) return whole();
        // Where b is small for its radius, the quotient of rounding is that of d to the rest.
        const double grown = 1 + slack * (d / rest), size = std::abs(b.x_) / rest;
        return a * Disc(b.x_ / rest, b.radius_ / rest * grown * up + size * (grown - 1) + size * slack);
    }
    Disc& operator+=(const Disc& o) { return *this = *this + o; }

    friend Disc square(const Disc& a) { return a * a; }
    /// The root with a positive real part; everything where a may be zero or negative. |sqrt(z) - sqrt(x)| =
    /// |z - x| / |sqrt(z) + sqrt(x)|, and the real part of sqrt(z) is at least sqrt(x - r): half the sum of
    /// |z| and z's own real part is its square.
    friend Disc sqrt(const Disc& a) {
        const double least = a.x_ * (1 - slack) - a.radius_;
        if (!(least > 0)) return whole();
        const double root = std::sqrt(a.x_);
        return rounded(root, a.radius_ / (root + std::sqrt(least)));
    }
    /// A disc that holds both.
    friend Disc hull(const Disc& a, const Disc& b) {
        return rounded(0.5 * (a.x_ + b.x_), 0.5 * std::abs(b.x_ - a.x_) + std::max(a.radius_, b.radius_) +
                                                slack * (std::abs(a.x_) + std::abs(b.x_)));
    }

    static Disc whole() { return {0, std::numeric_limits<double>::infinity()}; }

private:
    static constexpr double slack = 0x1p-48, up = 1 + slack;

    static Disc rounded(double center, double radius) {
        return {center, radius * up + std::abs(center) * slack};
    }

    double x_ = 0, radius_ = 0;
};

}  // namespace vcell::check
