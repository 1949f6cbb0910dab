/// Exact vectors of space, for predicates about planes, centres and axes.
#pragma once

#include "../../core/numbers/exact.hpp"
#include "objects.hpp"

namespace vcell {

struct ExactVector {
    Exact x, y, z;

    ExactVector() = default;
    ExactVector(Exact x_, Exact y_, Exact z_) : x(std::move(x_)), y(std::move(y_)), z(std::move(z_)) {}
    explicit ExactVector(const Vec3& p) : x(p.x()), y(p.y()), z(p.z()) {}

    friend ExactVector operator+(const ExactVector& p, const ExactVector& q) {
        return {p.x + q.x, p.y + q.y, p.z + q.z};
    }
    friend ExactVector operator-(const ExactVector& p, const ExactVector& q) {
        return {p.x - q.x, p.y - q.y, p.z - q.z};
    }
    friend ExactVector operator*(const Exact& s, const ExactVector& p) { return {s * p.x, s * p.y, s * p.z}; }
    bool is_zero() const {
        return x.sign() == Sign::Zero && y.sign() == Sign::Zero && z.sign() == Sign::Zero;
    }
};

inline Exact dot(const ExactVector& p, const ExactVector& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }

inline ExactVector cross(const ExactVector& p, const ExactVector& q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}

/// The double nearest to an exact number.
double nearest(const Exact& value);

/// The double nearest to sqrt(value). Pre: value > 0, its root in the range of doubles.
double rounded_sqrt(const Exact& value);

/// |n| within a part of 2^-105, a sum of two doubles: what planes keep of each other is that much better than
/// doubles tell, also where they are next to parallel. A length that is a double is exact. Planes whose |n|^2
/// agree, or differ by a power of four, have lengths that do. Pre: n is not zero.
Exact length_of(const ExactVector& n);

}  // namespace vcell
