/// Heights over a sphere or a cylinder base, in rational coordinates of the unit normal.
///
/// Canonical position: the sphere is centred at 0, the cylinder's axis is the y axis; the base point with
/// unit outward normal u is (0, y, 0) + R0 u (y = 0 on a sphere), the point at distance t from the centre or
/// the axis is (0, y, 0) + t u. In a chart u = n / W with polynomials n, W of the chart's coordinates
/// (primitives/charts/chart.hpp). The object is met at t = W / Q, where Q >= 0 is the larger root of
///
///     C Q^2 - 2 B Q - A^2 = 0,   B = b0 W + b.n + y slope A,   A = a.n,   C = c0 + c1 y + c2 y^2 > 0
///
/// ([HE, section 2.2] for any length of axes and normals; a = 0 but for cylinders: then Q = 2 B / C, and Q <=
/// 0 says never). The nearest object has the largest Q: heights are compared as f = -Q.
///
/// A tube or a cone seen from within (`is_hollow`) has + A^2 in the place of - A^2, with B > 0 and B^2 >= A^2
/// C: both roots are positive, or one of them is 0, and the larger one is where the ray first comes as near
/// to the wall as to the base. They are equal where the ray comes to the axis there: the bisector has a tip,
/// as that of a cone.
///
/// A tube that pierces the base, with delta = rho - R0 < 0 and an axis within -delta of its centre or axis,
/// has C < 0 (over a cylinder between two places), B < 0 there and B^2 + A^2 C >= 0. The same formula, (B +
/// sqrt(B^2 + A^2 C)) / C, tells where the ray is as near to the tube as to the base: of the two roots, both
/// of which are positive, the lesser Q, beyond the tube's axis. They are equal in tips, here too. Q = 0,
/// never, all along A = 0.
///
/// Over a cylinder C is concave in a tube or a ball, which holds the axis as long as C > 0, and has any shape
/// in a cone.
///
/// A cone has A = a0 W + a.n. With S and K the sine and cosine of half its angle, w its axis, m the way from
/// its apex to the base's centre or the base point's axis point, P = m.w S + R0 and m' = m - (m.w) w, a ray
/// is as near to the wall as to the base where
///
///     K |m' + t u'| = P - t (1 - S u.w),
///
/// which implies t (1 - S u.w) <= P. Squared it is the equation above, with q = Q / W = 1 / t and
///
///     C = P^2 - K^2 |m'|^2,   B = P (1 - S u.w) + K^2 m'.u,   A = u.w - S.
///
/// C - 2 B t + A^2 t^2 is C > 0 at t = 0 and no more than 0 where t (1 - S u.w) = P: the lesser t of both
/// roots is the one before that, where the right side above is no less than 0; the other one, if there is
/// one, is behind, where the wall's other half continues it. As m moves along y, B changes by -w_y A for each
/// length.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "../../core/numbers/exact.hpp"

namespace vcell {

/// The ends of a stretch of the y axis.
enum class AxialEnd : std::uint8_t { Low, High };

/// Places on a cylinder's axis a little beyond the ends of a region, where a form's C has its root: what
/// meets the axis obliquely there has heights that grow without bound towards it.
struct AxialTips {
    std::array<std::optional<double>, 2> y;  ///< below and above the region
    double reach = 1;                        ///< the region's length

    const std::optional<double>& operator[](AxialEnd end) const { return y[static_cast<std::size_t>(end)]; }
    std::optional<double>& operator[](AxialEnd end) { return y[static_cast<std::size_t>(end)]; }
    bool any() const { return y[0] || y[1]; }
};

/// The coefficients above, exact.
struct RadialForm {
    std::array<Exact, 3> c;  ///< c1 = c2 = 0 over a sphere
    Exact b0, slope;
    std::array<Exact, 3> b, a;
    bool is_hollow = false;
    Exact a0{};  ///< of cones only

    bool has_root() const {
        return a[0].sign() != Sign::Zero || a[1].sign() != Sign::Zero || a[2].sign() != Sign::Zero ||
               a0.sign() != Sign::Zero;
    }
    /// The end towards which C falls to a root, if it is linear and the height a quotient: planes over a
    /// cylinder.
    std::optional<AxialEnd> falls_to() const {
        const Sign rise = c[1].sign();
        if (has_root() || c[2].sign() != Sign::Zero || rise == Sign::Zero) return std::nullopt;
        return rise == Sign::Positive ? AxialEnd::Low : AxialEnd::High;
    }
};

}  // namespace vcell
