// What the integrals around spheres and cylinders are written with (radial_faces.cpp, round_integrals.cpp,
// radial_integrals.cpp).
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "radial_integrals.hpp"

namespace vcell::radial_integrals {

// Rounding of a coordinate, as a part of it, in units of term_rounding.
inline constexpr double noise = std::numeric_limits<double>::epsilon() / 2 / span_integrals::term_rounding;

/// A quotient of exact numbers, to rounding. Pre: below != 0.
inline double quotient(const Exact& above, const Exact& below) {
    return above.enclosure().mid() / below.enclosure().mid();
}

using Vector = std::array<double, 3>;

inline double dot(const Vec3& a, const Vector& b) { return a.x() * b[0] + a.y() * b[1] + a.z() * b[2]; }
inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double norm(const Vector& a) { return std::sqrt(dot(a, a)); }

/// What density(cos alpha, sin alpha) adds up to once around, by the trapezoidal rule with twice as many
/// points until it changes by next to nothing. The density's rests are bounds on its rounding; those of the
/// sum hold the last change, too, which is far more than what the rule leaves out then.
template <class Density>
Share sum_around(const Density& density) {
    constexpr int least_points = 16, most_points = 1 << 16;
    constexpr double enough = 0x1p-44;  // of the sum
    const auto add = [&](Share& sum, int i, int points) {
        const double angle = 2 * std::numbers::pi * i / points;
        const Share at = density(std::cos(angle), std::sin(angle));
        sum.volume += at.volume;
        sum.area += at.area;
        sum.volume_rest += at.volume_rest;
        sum.area_rest += at.area_rest;
    };
    Share sum{0, 0};
    for (int i = 0; i < least_points; ++i) add(sum, i, least_points);
    for (int points = least_points;; points *= 2) {
        Share finer = sum;
        for (int i = 1; i < 2 * points; i += 2) add(finer, i, 2 * points);
        // Means of half as many points are twice as great.
        const double volume = std::abs(finer.volume - 2 * sum.volume),
                     area = std::abs(finer.area - 2 * sum.area);
        const bool is_enough =
            volume <= enough * std::abs(finer.volume) && area <= enough * std::abs(finer.area);
        if (is_enough || 2 * points == most_points) {
            const double share = std::numbers::pi / points;
            return {share * finer.volume, share * finer.area, share * (finer.volume_rest + volume),
                    share * (finer.area_rest + area)};
        }
        sum = finer;
    }
}

}  // namespace vcell::radial_integrals
