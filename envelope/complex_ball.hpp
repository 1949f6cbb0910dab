/// Disks of the complex plane: how large an analytic function may be on an ellipse around its interval.
///
/// Not rounded outwards: for bounds that are taken with a margin of more than a few thousand roundings. What
/// cannot be bounded (a divisor's disk around zero, a radicand's across the negative axis) has an infinite
/// radius.
#pragma once

#include "../core/platform.hpp"

#include <cmath>
#include <complex>
#include <limits>

namespace vcell {

struct ComplexBall {
    std::complex<double> center;
    double radius = 0;

    ComplexBall(double x = 0) : center(x) {}  // NOLINT: a number is a disk
    ComplexBall(std::complex<double> c, double r) : center(c), radius(r) {}

    double magnitude() const { return std::abs(center) + radius; }

    friend ComplexBall operator-(const ComplexBall& a) { return {-a.center, a.radius}; }
    friend ComplexBall operator+(const ComplexBall& a, const ComplexBall& b) {
        return {a.center + b.center, a.radius + b.radius};
    }
    friend ComplexBall operator-(const ComplexBall& a, const ComplexBall& b) {
        return {a.center - b.center, a.radius + b.radius};
    }
    friend ComplexBall operator*(const ComplexBall& a, const ComplexBall& b) {
        return {product(a.center, b.center),
                std::abs(a.center) * b.radius + a.radius * (std::abs(b.center) + b.radius)};
    }
    friend ComplexBall operator/(const ComplexBall& a, const ComplexBall& b) {
        const double size = std::abs(b.center), least = size - b.radius;
        if (!(least > 0)) return {0.0, std::numeric_limits<double>::infinity()};
        return a * ComplexBall(std::conj(b.center) / (size * size), b.radius / (size * least));
    }
    /// The principal root: |sqrt z - sqrt c| <= |z - c| / |sqrt c| where the disk does not meet the negative
    /// axis.
    friend ComplexBall sqrt(const ComplexBall& a) {
        const double room = a.center.real() > 0 ? std::abs(a.center) : std::abs(a.center.imag());
        if (!(room > a.radius)) return {0.0, std::numeric_limits<double>::infinity()};
        const std::complex<double> root = std::sqrt(a.center);
        return {root, a.radius / std::abs(root)};
    }

private:
    // Without the library's detour for infinities.
    static std::complex<double> product(std::complex<double> a, std::complex<double> b) {
        return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
    }
};

}  // namespace vcell
