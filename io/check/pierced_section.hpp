/// Faces of tubes that pierce a ball or another tube, in coordinates about the piercing tube's axis, in which
/// they are as smooth next to its bisector's tips as anywhere else.
///
/// With d that axis, T = c + h d its points, c across d, D what the base's radius is more than the tube's,
/// and P what is across the base's axis z (of a ball all), points of the bisector are T + rho e, e(phi)
/// across d, with
///
///     |P (T + rho e)| = r = rho + D,
///     C - 2 B rho - A^2 rho^2 = 0,   C = |P T|^2 - D^2,   B = D - P T e,   A = z e (of a ball 0).
///
/// C = 0 in a tip, and C > 0 beyond it. With n the base's normal there and R = sqrt(B^2 + A^2 C) = r (1 - n
/// e) the derivatives by h and phi have the cross product rho (n - e) / (1 - n e): they make
///
///     dS = rho sqrt(2 r / R) dh dphi,   dV = rho r dh dphi / 2,   about a ball / 3.
///
/// A face is what lies between a tip, where all phi are one point, and its edges, whether it holds the tip or
/// not.
#pragma once

#include "axial_root.hpp"
#include "equation.hpp"
#include "triads.hpp"

namespace vcell::check {

/// A tube that pierces the base, beyond one of its bisector's tips.
struct Pierced {
    Equation tube;
    double share;                        ///< of rho r dh dphi in the volume
    MidRad D, tip;                       ///< tip: h there
    MidRad of_square, of_h;              ///< C = of_square (h^2 - tip^2) + of_h (h - tip)
    MidRad c_along, d_along;             ///< z of c and d; about a ball 0
    std::array<MidRad, 2> across_along;  ///< that of the frame across d

    /// The tube beyond the tip that is farther along its axis, or beyond the other one. None: it is not
    /// certain that it pierces the base.
    static std::optional<Pierced> beyond(const Equation& tube, bool is_ball, bool is_far) {
        if (tube.kind != Equation::Kind::tube || tube.is_hollow || !(tube.delta.upper() < 0))
            return std::nullopt;
        Pierced p{tube, is_ball ? 1.0 / 3 : 0.5, -tube.delta, 0.0, 1.0, 0.0, 0.0, 0.0, {0.0, 0.0}};
        const auto& [x, y] = tube.across_c;
        MidRad rest = square(x) + square(y) - square(p.D);
        if (!is_ball) {
            p.across_along = {tube.across[0][2], tube.across[1][2]};
            p.d_along = tube.d[2];
            p.c_along = x * p.across_along[0] + y * p.across_along[1];
            p.of_square = square(tube.d[0]) + square(tube.d[1]);
            p.of_h = -2.0 * (p.c_along * p.d_along);
            rest = rest - square(p.c_along);
        }
        const MidRad discriminant = square(p.of_h) - 4.0 * (p.of_square * rest);
        // In a tube's all but touching or parallel one tips are not told.
        if (!(p.of_square.lower() > 0) || !(discriminant.lower() > 0)) return std::nullopt;
        const MidRad root = sqrt(discriminant);
        p.tip = 0.5 * ((is_far ? root : -root) - p.of_h) / p.of_square;
        return p;
    }
    Triad<MidRad> point() const {
        Triad<MidRad> p;
        for (const std::size_t i : {0, 1, 2})
            p[i] =
                tube.across_c[0] * tube.across[0][i] + tube.across_c[1] * tube.across[1][i] + tip * tube.d[i];
        return p;
    }
};

/// What lies between the tip and an edge, at one place of the edge.
template <class T>
class PiercedSection {
public:
    /// foot + t u is the bisector's point over the edge's, u the base's normal; d_foot and du: per ds.
    PiercedSection(const Pierced& pierced, const Triad<T>& foot, const Triad<T>& d_foot, const Triad<T>& u,
                   const Triad<T>& du, const T& t)
        : pierced_(pierced) {
        const Equation& e = pierced.tube;
        std::array<T, 2> off;
        for (const std::size_t i : {0, 1})
            off[i] = dot(e.across[i], foot) + t * dot(e.across[i], u) - T(e.across_c[i]);
        const T rho = sqrt(square(off[0]) + square(off[1]));
        e_ = {off[0] / rho, off[1] / rho};
        const auto along_e = [&](const Triad<T>& v) {
            return e_[0] * dot(e.across[0], v) + e_[1] * dot(e.across[1], v);
        };
        const auto about_axis = [&](const Triad<T>& v) {
            return e_[0] * dot(e.across[1], v) - e_[1] * dot(e.across[0], v);
        };
        // On the bisector t' = e S'.
        const T dt = (along_e(d_foot) + t * along_e(du)) / (T(1.0) - along_e(u));
        rise_ = dot(e.d, foot) + t * dot(e.d, u) - T(pierced.tip);
        size_ = rise_ * (about_axis(d_foot) + dt * about_axis(u) + t * about_axis(du)) / rho;
        A_ = e_[0] * T(pierced.across_along[0]) + e_[1] * T(pierced.across_along[1]);
        // P T e = c e - (z T) (z e)
        start_ = T(pierced.D) - e_[0] * T(e.across_c[0]) - e_[1] * T(e.across_c[1]) + T(pierced.c_along) * A_;
    }

    struct At {
        T volume, area, steepness;
    };
    /// At sigma in [0, 1] of the way to the edge, per d sigma and per ds along the edge that the face lies on
    /// the left of.
    At at(const T& sigma) const {
        const T way = sigma * rise_, h = way + T(pierced_.tip);
        const T C = way * (T(pierced_.of_square) * (h + T(pierced_.tip)) + T(pierced_.of_h)),
                B = start_ + h * (T(pierced_.d_along) * A_);
        const T root = sqrt(square(B) + square(A_) * C), rho = axial_root(C, B, A_, root),
                r = rho + T(pierced_.D), steepness = sqrt(2.0 * r / root);
        return {pierced_.share * (size_ * rho * r), size_ * rho * steepness, steepness};
    }

private:
    const Pierced& pierced_;
    std::array<T, 2> e_;
    T rise_, size_, A_, start_;
};

}  // namespace vcell::check
