/// Vectors of any kind of numbers.
#pragma once

#include <cstddef>

#include "frame.hpp"

namespace vcell::check {

template <class S, class T>
auto dot(const Triad<S>& a, const Triad<T>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
T squared_norm(const Triad<T>& a) {
    return square(a[0]) + square(a[1]) + square(a[2]);
}
template <class S, class T>
T determinant(const Triad<S>& a, const Triad<T>& b, const Triad<T>& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}
template <class T>
Triad<T> scaled(const T& s, const Triad<T>& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
template <class T>
Triad<T> normalized(const Triad<T>& a) {
    // A component is the whole length: nothing to round.
    for (std::size_t i = 0; i < 3; ++i)
        if (a[(i + 1) % 3].magnitude() == 0 && a[(i + 2) % 3].magnitude() == 0) {
            Triad<T> result{};
            result[i] = a[i].lower() > 0 ? 1.0 : -1.0;
            return result;
        }
    return scaled(T(1.0) / sqrt(squared_norm(a)), a);
}
template <class S, class T>
Triad<T> cross(const Triad<S>& a, const Triad<T>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Triad<MidRad> near(const Triad<Interval>& a) { return {a[0], a[1], a[2]}; }

}  // namespace vcell::check
