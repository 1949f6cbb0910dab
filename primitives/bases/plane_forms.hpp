// The heights of balls, planes and sides of the box over a plane base, as plane_base.hpp has them.
#pragma once

#include <array>

#include "../../core/curves/circular_form.hpp"
#include "../../core/numbers/exact.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"

namespace vcell {

// A ball in canonical coordinates, all of it times d.
struct ExactBall {
    ExactVector c;
    Exact rho, d;

    Exact behind() const { return c.z - rho; }  // height of the lowest point
    Exact width() const { return c.z + rho; }   // beta
};

// Each of the four operations below is one rounding of exact operands or two of rounded ones: e has a
// relative error of 3u, w of u.
inline CircularForm ball_form(const Ball& s) {
    CircularForm f;
    f.k = 1;
    f.cx = s.cx;
    f.cy = s.cy;
    f.e = (s.cz - s.rho) * (s.cz + s.rho);
    f.w = 2 * (s.cz + s.rho);
    return f;
}

inline ExactForm exact_ball_form(const ExactBall& s) {
    const Exact twice_d = 2.0 * s.d;
    return {s.d * s.d, -(twice_d * s.c.x), -(twice_d * s.c.y),
            s.c.x * s.c.x + s.c.y * s.c.y + s.behind() * s.width(), twice_d * s.width()};
}

// About a centre in doubles, what it is off by in the linear terms: |p - c|^2 = |p - c~|^2 + 2 (c~ - c).p +
// |c|^2 - |c~|^2. Coefficients are quotients of correctly rounded numbers: relative errors of 3u.
inline CircularForm ball_form(const ExactBall& s) {
    const double d = nearest(s.d), d2 = nearest(s.d * s.d);
    CircularForm f;
    f.k = 1;
    f.cx = nearest(s.c.x) / d;
    f.cy = nearest(s.c.y) / d;
    const Exact cx = s.d * Exact(f.cx), cy = s.d * Exact(f.cy);
    f.a = 2 * nearest(cx - s.c.x) / d;
    f.b = 2 * nearest(cy - s.c.y) / d;
    f.e = nearest(s.c.x * s.c.x + s.c.y * s.c.y - cx * cx - cy * cy + s.behind() * s.width()) / d2;
    f.w = 2 * nearest(s.width()) / d;
    return f;
}

// (A x + B y + C) / W, of a plane or a box side.
using LinearForm = std::array<Exact, 4>;

// n.p + d with the region on the positive side.
struct HalfSpaceOverBase {
    ExactVector n;
    Exact d, length;  // |n| as length_of() has it
};

// Height of the plane n.p + d = 0 seen from its positive side: C = nx x + ny y + d, 2 beta = |n| - nz,
// both multiplied by |n| + nz where the difference would cancel.
inline LinearForm plane_form(const HalfSpaceOverBase& h) {
    const ExactVector& n = h.n;
    if (n.z.sign() != Sign::Positive) return {n.x, n.y, h.d, h.length - n.z};
    const Exact factor = h.length + n.z;
    return {factor * n.x, factor * n.y, factor * h.d, n.x * n.x + n.y * n.y};
}

}  // namespace vcell
