/// Vectors of intervals, or of Wide numbers.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/wide.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell::check {

inline double lower_bound(const Interval& x) { return x.lower(); }
inline double upper_bound(const Interval& x) { return x.upper(); }
inline double lower_bound(const Wide& x) { return x.enclosure().lower(); }
inline double upper_bound(const Wide& x) { return x.enclosure().upper(); }

template <class T>
using Vector = std::array<T, 3>;

template <class T>
Vector<T> to_vector(const Vec3& v) {
    return {T(v[0]), T(v[1]), T(v[2])};
}
template <class T>
Vector<T> operator+(const Vector<T>& a, const Vector<T>& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
Vector<T> operator-(const Vector<T>& a, const Vector<T>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
Vector<T> operator*(const T& s, const Vector<T>& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
template <class T>
T dot(const Vector<T>& a, const Vector<T>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
T square(const Vector<T>& a) {
    return square(a[0]) + square(a[1]) + square(a[2]);
}
template <class T>
Vector<T> cross(const Vector<T>& a, const Vector<T>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
Vector<T> hull(const Vector<T>& a, const Vector<T>& b) {
    return {hull(a[0], b[0]), hull(a[1], b[1]), hull(a[2], b[2])};
}
template <class T>
T magnitude(const T& a) {
    if (a.lower() >= 0) return a;
    if (a.upper() <= 0) return -a;
    return hull(T(0.0), hull(a, -a));
}

/// The direction of v, each coordinate within [-1, 1] whatever v holds.
template <class T>
Vector<T> direction(const Vector<T>& v, const T& length) {
    const auto clip = [](const T& x) {
        const T unit(-1.0, 1.0);
        return T(std::max(x.lower(), unit.lower()), std::min(x.upper(), unit.upper()));
    };
    return {clip(v[0] / length), clip(v[1] / length), clip(v[2] / length)};
}

inline Vec3 middle(const Vector<Interval>& v) { return {v[0].mid(), v[1].mid(), v[2].mid()}; }
/// The box about p that reaches r to either side.
inline Vector<Interval> box_about(const Vec3& p, double r) {
    return {Interval::ball(p[0], r), Interval::ball(p[1], r), Interval::ball(p[2], r)};
}
/// The box about another one.
inline Vector<Interval> box_about(const Vector<Interval>& box, double r) {
    const Interval m(-r, r);
    return {box[0] + m, box[1] + m, box[2] + m};
}
/// Upper bound of the distance of a point of the box from its middle.
inline double radius(const Vector<Interval>& v) {
    const double x = v[0].radius(), y = v[1].radius(), z = v[2].radius();
    // Squares may be lost below normal numbers.
    return std::sqrt(x * x + y * y + z * z) * (1 + 0x1p-50) + 0x1p-500;
}

}  // namespace vcell::check
