/// Faces of hollow tubes and cones around a ball, in coordinates about the vessel's axis in which they are as
/// smooth where the axis comes near as anywhere else.
///
/// With w the axis, e(phi) across it, e' = w x e, S and K the sine and cosine of half a cone's angle (0 and 1
/// in a tube), g = K w + S e along the wall and n = S w - K e its normal, and D the ball's centre as seen
/// from the apex (from a point of the axis), points of the bisector are apex + v g + r n with
///   |v g + r n - D| = R0 + r,   r = ((v - D g)^2 + (D e')^2 + (D n)^2 - R0^2) / (2 G),   G = R0 + D n,
/// where a tube counts r from the axis on and has its radius added to R0. With rho = S v - K r the distance
/// from the axis, the derivatives by phi and v have the cross product
///   N = rho (-n + (v - D g) / G g - (D e') / G e'),
/// and (P N) / 3, P as seen from the ball's centre, is the volume's density: all of them rational. A face is
/// what lies between a constant v and its edges; where it holds a tip, a point of the axis, v is one and the
/// same there for all phi, and what lies between all around counts, too. An edge's v and phi are those of the
/// bisector's point in its direction from the ball's centre, so that faces beside an edge meet in the same
/// directions.
#pragma once

#include "equation.hpp"
#include "triads.hpp"

namespace vcell::check {

/// What lies between a constant v and an edge, at one place of the edge.
template <class T>
class VesselSection {
public:
    /// start: K D w less than v. t: how far from the ball's centre the bisector is in the direction of p.
    VesselSection(const Equation& equation, const MidRad& start, const Place<T>& p, const T& t);
    /// What lies between two constant v, less K D w, and half the angle's tangent is s, about one direction
    /// across the axis or its opposite.
    VesselSection(const Equation& equation, const MidRad& start, const MidRad& end, bool is_opposite,
                  const T& s);

    struct At {
        T volume, area, steepness;
    };
    /// At sigma in [0, 1] of the way to the edge, per d sigma and per ds along the edge that the face lies on
    /// the left of.
    At at(const T& sigma) const;

private:
    void set_direction(const T& ex, const T& ey);

    const Equation& equation_;
    MidRad start_;                // K D w
    T first_, rise_, turn_;       // v less K D w at sigma = 0, by how much it grows; of the edge
    T along_, across_, off_, G_;  // S D e, D e', D n
};

/// Where the bisector comes to the vessel's axis: `points`, farther along it the second one, in the frame.
/// `pole` is opposite to the first one's direction from the ball's centre, `other` that of the second one in
/// the stereographic plane about the pole.
struct VesselTips {
    std::array<Triad<MidRad>, 2> points;
    Triad<MidRad> pole, other;

    explicit VesselTips(const Equation& e) {
        // f + k w with f across the axis: |f|^2 + k^2 = (R0 + S (k - c w))^2.
        const MidRad L = e.radius - e.sine * dot(e.d, e.c), K2 = square(e.cosine),
                     root = sqrt(square(L) - K2 * (square(e.across_c[0]) + square(e.across_c[1])));
        const auto tip = [&](const MidRad& k) {
            Triad<MidRad> p;
            for (const std::size_t i : {0, 1, 2})
                p[i] = e.across_c[0] * e.across[0][i] + e.across_c[1] * e.across[1][i] + k * e.d[i];
            return p;
        };
        points = {tip((e.sine * L - root) / K2), tip((e.sine * L + root) / K2)};
        pole = scaled(MidRad(-1.0), normalized(points[0]));
        const Triad<MidRad> u = normalized(points[1]);
        const MidRad q = dot(pole, u), share = MidRad(1.0) / (1.0 + q);
        for (const std::size_t i : {0, 1, 2}) other[i] = (u[i] - q * pole[i]) * share;
    }
};

/// By how much an edge turns around `other` in that plane per ds, as seen in its direction from the ball's
/// centre. A loop makes as many turns around the axis: both are angles on a sphere without the two tips. All
/// loops of a face together make one if it holds the second tip alone, and one the other way round if the
/// first.
template <class T>
T turn_between(const VesselTips& tips, const Place<T>& p) {
    const Triad<T> n = p.whole(), dn = p.whole_derivative();
    const T size = sqrt(squared_norm(n)), q = dot(tips.pole, n), dq = dot(tips.pole, dn), sum = size + q,
            d_sum = dot(n, dn) / size + dq;
    Triad<T> m, dm;
    for (const std::size_t i : {0, 1, 2}) {
        m[i] = n[i] - q * tips.pole[i] - sum * tips.other[i];
        dm[i] = dn[i] - dq * tips.pole[i] - d_sum * tips.other[i];
    }
    return determinant(tips.pole, m, dm) / squared_norm(m);
}

/// v less K D w of a point of the bisector, in the frame.
template <class T>
T along_wall(const Equation& e, const Triad<T>& p) {
    const T x = dot(e.across[0], p) - T(e.across_c[0]), y = dot(e.across[1], p) - T(e.across_c[1]);
    return e.cosine * dot(e.d, p) + e.sine * sqrt(square(x) + square(y));
}

template <class T>
VesselSection<T>::VesselSection(const Equation& e, const MidRad& start, const Place<T>& p, const T& t)
    : equation_(e) {
    const Triad<T> way = p.whole(), dn = p.whole_derivative();
    const T share = T(1.0) / sqrt(squared_norm(way));
    const Triad<T> u = scaled(share, way);
    const T growth = dot(u, dn);
    const Triad<T> du = scaled(share, {dn[0] - growth * u[0], dn[1] - growth * u[1], dn[2] - growth * u[2]});
    const T x = dot(e.across[0], u) * t - T(e.across_c[0]), y = dot(e.across[1], u) * t - T(e.across_c[1]);
    const T rho = sqrt(square(x) + square(y)), ex = x / rho, ey = y / rho;
    const auto about_axis = [&](const Triad<T>& a) {
        return ex * dot(e.across[1], a) - ey * dot(e.across[0], a);
    };
    const auto along_n = [&](const Triad<T>& a) {
        return e.sine * dot(e.d, a) - e.cosine * (ex * dot(e.across[0], a) + ey * dot(e.across[1], a));
    };
    // On the bisector t'/t = n u' / (1 - n u).
    turn_ = t / rho * (about_axis(du) + about_axis(u) * along_n(du) / (T(1.0) - along_n(u)));
    set_direction(ex, ey);
    first_ = T(start);
    rise_ = e.cosine * (dot(e.d, u) * t) + e.sine * rho - first_;
}

template <class T>
VesselSection<T>::VesselSection(const Equation& e, const MidRad& start, const MidRad& end, bool is_opposite,
                                const T& s)
    : equation_(e) {
    const T share = T(is_opposite ? -1.0 : 1.0) / (T(1.0) + square(s));
    set_direction((T(1.0) - square(s)) * share, 2.0 * (s * share));
    turn_ = T(2.0) / (T(1.0) + square(s));
    first_ = T(start);
    rise_ = T(end - start);
}

// D is the opposite of the apex as seen from the centre.
template <class T>
void VesselSection<T>::set_direction(const T& ex, const T& ey) {
    const Equation& e = equation_;
    const T out = -(e.across_c[0] * ex + e.across_c[1] * ey);
    across_ = e.across_c[0] * ey - e.across_c[1] * ex;
    const MidRad on_axis = -dot(e.d, e.c);
    start_ = e.cosine * on_axis;
    off_ = T(e.sine * on_axis) - e.cosine * out;
    G_ = T(e.radius) + off_;
    along_ = e.sine * out;
}

template <class T>
typename VesselSection<T>::At VesselSection<T>::at(const T& sigma) const {
    const Equation& e = equation_;
    const T v = first_ + sigma * rise_, w = v - along_;
    const T squares = square(w) + square(across_);
    const T r = (squares + (off_ - T(e.radius)) * G_) / (2.0 * G_);
    const T rho = e.sine * (v + T(start_)) - e.cosine * r;
    const T size = rise_ * turn_ * rho / G_;
    const T root = sqrt(squares + square(G_));
    // The face is on the left: it lies above where phi grows.
    return {size * (squares + (off_ - r) * G_) * (-1.0 / 3.0), -(size * root), root / G_};
}

}  // namespace vcell::check
