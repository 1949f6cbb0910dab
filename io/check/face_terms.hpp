/// What integrands of faces (shadows.hpp) are made of, for all kinds of numbers.
#pragma once

#include <type_traits>

#include "quadrature.hpp"
#include "shadows.hpp"

namespace vcell::check {

inline const MidRad third = MidRad(1.0) / 3.0;

/// artanh(x) / x for |x| < 1, which is even.
MidRad artanh_ratio(const MidRad& x);
Approximate artanh_ratio(const Approximate& x);
Traced artanh_ratio(const Traced& x);

/// arctan(x) / x, by the square of x.
MidRad arctan_ratio(const MidRad& square_of_x);
Approximate arctan_ratio(const Approximate& square_of_x);

/// The area's integral about a sphere from the direction z to the axis, divided by 1 - z and K^2: with b = A
/// z + B,
///     int sqrt(E + 2 B b) / b^3 db / (b1 - b),
/// of which the antiderivative is -s / (2 b^2) - B s / (2 E b) - (B^2 / E) artanh(sqrt(E) / s) / sqrt(E) up
/// to a sign in the last, s = sqrt(E + 2 B b). Differences of roots are quotients, so that nothing cancels
/// near the axis. Of an ellipsoid E is negative, and the last is an arctan.
template <class T>
T antiderivative(const Revolved& r, const T& b) {
    const T b1(r.b1), B(r.B), E(r.E);
    if (r.is_paraboloid) {
        const T x = sqrt(b), y = sqrt(b1), xy = x * y;
        return sqrt(2.0 * B) * (2.0 / T(3.0)) * (b + b1 + xy) / ((x + y) * xy * square(xy));
    }
    const T s = sqrt(E + 2.0 * (B * b)), s1 = sqrt(E + 2.0 * (B * b1)), sum = s + s1;
    const T first = (s * (b1 + b) - 2.0 * (B * square(b)) / sum) / (2.0 * square(b * b1));
    if (r.B.magnitude() == 0) return first;
    const T second = B / (2.0 * E) * (s - 2.0 * (B * b) / sum) / (b * b1);
    if (r.E.upper() < 0) {
        const T ratio = 2.0 * B / (sum * (s * s1 - E)), x2 = -E * square((b1 - b) * ratio);
        return first + second - square(B) / E * ratio * T(arctan_ratio(x2));
    }
    const T ratio = (s * s1 + E) / (sum * (E * (b + b1) + 2.0 * (B * b * b1)));
    const T x = sqrt(E) * (b1 - b) * ratio;
    return first + second - square(B) / E * ratio * T(artanh_ratio(x));
}
/// How far rounding may take the antiderivative from the true one, at any b of a disc's real part: `error` is
/// that of the b that it is computed at. Infinite where nothing is known.
double error_of_antiderivative(const Revolved& r, const Disc& b, double error);

template <class T>
T revolved_area(const Revolved& r, const T& b) {
    const T b1(r.b1), B(r.B), E(r.E);
    if constexpr (std::is_same_v<T, Disc>) {
        // The mean of the integrand between b and b1 lies in any disc that holds its values.
        const T all = hull(b, b1);
        return sqrt(E + 2.0 * (B * all)) / all / all / all;
    } else if constexpr (std::is_same_v<T, Traced>) {
        // So it does here; values are computed, and rounded, as below.
        return {revolved_area(r, b.range()), error_of_antiderivative(r, b.range(), b.error())};
    } else {
        return antiderivative(r, b);
    }
}

/// A paraboloid's, of a turn about its axis and the squared distance s^2 from it. With s^2 = m k^2 and
/// r = sqrt(1 + m): the integral of r from the axis is k^2 (r^3 - 1) / 3.
template <class T>
Densities<T> below_paraboloid(const Paraboloid& h, const T& turn, const T& s2) {
    const T volume = (0.25 * s2 + T(h.half_of_e)) * turn * T(h.half_by_k);
    const T r = sqrt(T(1.0) + s2 * T(h.one_by_k2));
    return {volume, (square(r) + r + T(1.0)) / (T(3.0) * (r + T(1.0))) * turn, 0.5 * turn, r};
}

}  // namespace vcell::check
