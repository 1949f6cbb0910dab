/// Disks of the complex plane: how large an analytic function may be on an ellipse around its interval.
///
/// Not rounded outwards: for bounds that are taken with a margin of more than a few thousand roundings, and
/// of numbers whose squares neither overflow (they are not bounded) nor vanish. What cannot be bounded (a
/// divisor's disk around zero, a radicand's across the negative axis) has an infinite radius.
#pragma once

#include "../platform.hpp"

#include <cmath>
#include <complex>
#include <limits>

namespace vcell {

struct ComplexBall {
    std::complex<double> center;
    double radius = 0;

    ComplexBall(double x = 0) : center(x) {}  // NOLINT: a number is a disk
    ComplexBall(std::complex<double> c, double r) : center(c), radius(r) {}

    double magnitude() const { return size(center) + radius; }

    friend ComplexBall operator-(const ComplexBall& a) { return {-a.center, a.radius}; }
    friend ComplexBall operator+(const ComplexBall& a, const ComplexBall& b) {
        return {a.center + b.center, a.radius + b.radius};
    }
    friend ComplexBall operator-(const ComplexBall& a, const ComplexBall& b) {
        return {a.center - b.center, a.radius + b.radius};
    }
    friend ComplexBall operator*(const ComplexBall& a, const ComplexBall& b) {
        return {product(a.center, b.center),
                size(a.center) * b.radius + a.radius * (size(b.center) + b.radius)};
    }
    friend ComplexBall operator/(const ComplexBall& a, const ComplexBall& b) {
        const double length = size(b.center), least = length - b.radius;
        if (!(least > 0)) return {0.0, std::numeric_limits<double>::infinity()};
        return a * ComplexBall(std::conj(b.center) / (length * length), b.radius / (length * least));
    }
    /// The principal root: |sqrt z - sqrt c| <= |z - c| / |sqrt c| where the disk does not meet the negative
    /// axis.
    friend ComplexBall sqrt(const ComplexBall& a) {
        const double room = a.center.real() > 0 ? size(a.center) : std::abs(a.center.imag());
        if (!(room > a.radius)) return {0.0, std::numeric_limits<double>::infinity()};
        const std::complex<double> root = std::sqrt(a.center);
        return {root, a.radius / size(root)};
    }

private:
    static double size(std::complex<double> a) {
        return std::sqrt(a.real() * a.real() + a.imag() * a.imag());
    }
    // Without the library's detour for infinities.
    static std::complex<double> product(std::complex<double> a, std::complex<double> b) {
        return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
    }
};

}  // namespace vcell
