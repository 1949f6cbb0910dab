/// How far doubles may stray from what they stand for, all over a disc at once.
///
/// An expression evaluated once in this arithmetic, over a disc of its variable, says how much rounding its
/// values in plain doubles may have gathered at any real number in the disc. So one evaluation bounds an
/// integrand about an interval, and answers for all the nodes of a quadrature rule in it.
#pragma once

#include <cmath>
#include <limits>

#include "disc.hpp"

namespace vcell::check {

class Traced {
public:
    Traced() = default;
    Traced(double value) : range_(value) {}  // NOLINT: a number, as it is
    Traced(const MidRad& constant)
        : range_(constant), error_(constant.radius()) {}  // NOLINT: its midpoint is used
    Traced(const Disc& range, double error) : range_(range), error_(error) {}

    /// Of the true values.
    const Disc& range() const { return range_; }
    /// Of the computed ones from the true ones, at most; infinite or not a number where nothing is known.
    double error() const { return error_; }
    double magnitude() const { return range_.magnitude(); }
    static Traced whole() { return {Disc::whole(), std::numeric_limits<double>::infinity()}; }

    friend Traced operator-(const Traced& a) { return {-a.range_, a.error_}; }
    friend Traced operator+(const Traced& a, const Traced& b) {
        return rounded(a.range_ + b.range_, a.error_ + b.error_);
    }
    friend Traced operator-(const Traced& a, const Traced& b) {
        return rounded(a.range_ - b.range_, a.error_ + b.error_);
    }
    friend Traced operator*(const Traced& a, const Traced& b) {
        return rounded(a.range_ * b.range_, a.magnitude() * b.error_ + a.error_ * (b.magnitude() + b.error_));
    }
    friend Traced operator*(double s, const Traced& a) {
        return rounded(s * a.range_, std::abs(s) * a.error_);
    }
    /// |x' / y' - x / y| <= (|x' - x| + |x / y| |y' - y|) / |y'|.
    friend Traced operator/(const Traced& a, const Traced& b) {
        const Disc quotient = a.range_ / b.range_;
        const double least = (std::abs(b.range_.center()) - b.range_.radius() - b.error_) * down;
        if (!(least > 0)) return whole();
        return rounded(quotient, (a.error_ + quotient.magnitude() * b.error_) / least);
    }
    friend Traced square(const Traced& a) { return a * a; }
    /// |sqrt(x') - sqrt(x)| <= |x' - x| / (2 sqrt(least of both)).
    friend Traced sqrt(const Traced& a) {
        const double least = (a.range_.center() - a.range_.radius() - a.error_) * down;
        if (!(least > 0)) return whole();
        return rounded(sqrt(a.range_), a.error_ / (2 * std::sqrt(least)));
    }

private:
    static constexpr double up = 1 + 0x1p-48, down = 1 - 0x1p-48;

    // Rounding to nearest of a number that is no larger than the true one and its error.
    static Traced rounded(const Disc& range, double error) {
        return {range, error * up + (0x1p-53 * up) * range.magnitude() + std::numeric_limits<double>::min()};
    }

    Disc range_;
    double error_ = 0;
};

}  // namespace vcell::check
