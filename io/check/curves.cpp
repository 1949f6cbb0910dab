#include "curves.hpp"

#include <cfloat>

namespace vcell::check {

Bernstein::Bernstein(int d, double s) {
    value[0] = 1;
    for (int n = 1; n <= d; ++n) {
        if (n == d)
            for (int i = 0; i <= d; ++i) slope[i] = d * ((i > 0 ? value[i - 1] : 0) - (i < d ? value[i] : 0));
        value[n] = s * value[n - 1];
        for (int i = n - 1; i > 0; --i) value[i] = (1 - s) * value[i] + s * value[i - 1];
        value[0] *= 1 - s;
    }
}

SurfacePoint evaluate(const RationalPatch& s, double u, double v) {
    const double du = s.domain_u[1] - s.domain_u[0], dv = s.domain_v[1] - s.domain_v[0];
    const Bernstein bu(s.degree_u, (u - s.domain_u[0]) / du), bv(s.degree_v, (v - s.domain_v[0]) / dv);
    Eigen::Vector4d h = Eigen::Vector4d::Zero(), hu = h, hv = h;
    for (int i = 0; i <= s.degree_u; ++i)
        for (int j = 0; j <= s.degree_v; ++j) {
            Eigen::Vector4d c = s.points[i * (s.degree_v + 1) + j];
            c.head<3>() *= c[3];
            h += bu.value[i] * bv.value[j] * c;
            hu += bu.slope[i] * bv.value[j] / du * c;
            hv += bu.value[i] * bv.slope[j] / dv * c;
        }
    const Vec3 p = h.head<3>() / h[3];
    return {p, (hu.head<3>() - hu[3] * p) / h[3], (hv.head<3>() - hv[3] * p) / h[3]};
}

// Where q is outside the box of the control points, curve and chord turn by the same angle, less than pi.
std::optional<double> swept(const Bezier<2>& c, const Vec2& q, const Vec2& near) {
    Vec2 lo = c.control(0), hi = lo;
    for (std::size_t i = 1; i < c.points.size(); ++i) {
        lo = lo.cwiseMin(c.control(i));
        hi = hi.cwiseMax(c.control(i));
    }
    const bool outside = (q.array() < (lo - near).array()).any() || (q.array() > (hi + near).array()).any();
    if (outside) {
        const Vec2 a = c.control(0) - q, b = c.control(c.points.size() - 1) - q;
        return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
    // A box that rounding keeps from shrinking holds q for ever: q lies on the curve as far as doubles tell.
    const Vec2 least = near.cwiseMax(4 * DBL_EPSILON * lo.cwiseAbs().cwiseMax(hi.cwiseAbs()));
    if (!((hi - lo).array() > least.array()).any()) return std::nullopt;
    double total = 0;
    for (const auto& half : c.halves()) {
        const auto angle = swept(half, q, near);
        if (!angle) return std::nullopt;
        total += *angle;
    }
    return total;
}

}  // namespace vcell::check
