/// The face of a tube of a base tube's radius, skew to it, as an integrand over the plane of both axes.
///
/// With z along the common perpendicular of the axes, towards the tube, h their distance and s c = sine / 2
/// of their angle, and x and y on the bisectors of their directions, X and Y counted from the crossing, the
/// face is where z = h / 2 - steep X Y, steep = sine / h, z from the base's axis. Over a piece of that plane
/// it has sqrt(1 + w) times its area, w = steep^2 (X^2 + Y^2), and the part across the base's axis of the way
/// from there has, along z + steep (Y x + X y), what is a polynomial of degree two: both are told by angles
/// that an edge sweeps, about the crossing and about a point near the face. Next to the base rays hardly meet
/// the face, and along them nothing is told.
#pragma once

#include <optional>
#include <span>

#include "densities.hpp"
#include "triads.hpp"

namespace vcell::check {

struct Saddle {
    Triad<MidRad> x, y, z;
    Triad<double> corner;  ///< near the face
    Triad<MidRad> at;      ///< of the corner: X, Y, and its height over the face along z
    MidRad steep;
    /// Half of the polynomial about the corner: its value and slopes there, and what |a|^2 counts.
    MidRad half_value, half_square;
    std::array<MidRad, 2> half_slope;

    /// None if it is no such tube, digits do not tell the axes' distance, the crossing is far away, or rays
    /// meet the face better about the corners than what goes along z: edges are as far off along either as
    /// they are off, over its cosine.
    static std::optional<Saddle> of(const Cylinder& base, const Cylinder& tube, const Frame& frame,
                                    std::span<const Triad<double>> corners);
};

/// The face below an edge along z, and the wall between both, whose volume towards the base's axis counts;
/// the shadow is seen from that.
template <class T>
Densities<T> along(const Saddle& f, const Place<T>& p) {
    Triad<T> q, velocity;
    for (const std::size_t i : {0, 1, 2}) {
        q[i] = (p.n[i] - (MidRad(f.corner[i]) - MidRad(p.origin[i])) * p.w) / p.w;
        velocity[i] = (p.dn[i] * p.w - p.n[i] * p.dw) / square(p.w);
    }
    const T a = dot(f.x, q), b = dot(f.y, q), da = dot(f.x, velocity), db = dot(f.y, velocity);
    const T X = a + T(f.at[0]), Y = b + T(f.at[1]);
    const T squared = f.steep * f.steep * (square(X) + square(Y)), element = sqrt(T(1.0) + squared);
    const T swept = (squared + T(2.0) + element) / (3.0 * (T(1.0) + element));
    // X Y is more than that of the corner by a Y + X_corner b.
    const T above = T(f.at[2]) + dot(f.z, q) + f.steep * (a * Y + f.at[0] * b);
    const Triad<T> across = cross(f.z, velocity);
    const T x = q[0] + T(f.corner[0]), y = q[1] + T(f.corner[1]);
    const T middle_x = x - 0.5 * (f.z[0] * above), middle_y = y - 0.5 * (f.z[1] * above);
    const T wall = 0.5 * above * (middle_x * across[0] + middle_y * across[1]);
    const T value = 0.5 * T(f.half_value) +
                    T(MidRad(1.0) / 3.0) * (f.half_slope[0] * a + f.half_slope[1] * b) +
                    0.25 * (f.half_square * (square(a) + square(b)));
    const T turn = q[2] * (y * velocity[0] - x * velocity[1]) / (square(x) + square(y));
    return {value * (a * db - b * da) + wall, swept * (X * db - Y * da), turn, element};
}

}  // namespace vcell::check
