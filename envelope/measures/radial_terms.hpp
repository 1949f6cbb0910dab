// What the integrals around spheres and cylinders are written with (radial_faces.cpp, round_integrals.cpp,
// radial_integrals.cpp).
#pragma once

#include <array>
#include <cmath>
#include <limits>

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

}  // namespace vcell::radial_integrals
