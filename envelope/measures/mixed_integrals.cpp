#include "mixed_integrals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "../diagram/chart_arc.hpp"
#include "span_integrals.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using span_integrals::integrate;
using span_integrals::PowerSpan;
using span_integrals::SpanPoint;
using span_integrals::term_rounding;
using std::sqrt;

using roundoff::u;

PowerSpan power_span(ControlPoints span) { return PowerSpan(span, span.front().head<3>()); }

// ---- Circular forms: the fields of measures.cpp -----------------------------------------------------

struct CircularIntegrand {
    Vector2d o;
    double f0, c;
    Vector2d g;
    Vector2d center;
    double k, w, stretch;

    CircularIntegrand(const CircularForm& f, const Vector2d& origin)
        : o(origin),
          f0(f(o.x(), o.y())),
          c(f.k / f.w),
          g(gradient(f, o)),
          center(f.cx, f.cy),
          k(f.k),
          w(f.w),
          stretch(std::hypot(1, f.a / f.w, f.b / f.w)) {}

    template <class T>
    std::array<T, 3> operator()(const SpanPoint<T>& p) const {
        const T x = p.x - T(o.x()), y = p.y - T(o.y());
        const T turn = x * p.y1 - y * p.x1;
        const T factor = T(c / 4) * (x * x + y * y) + T(g.x() / 3) * x + T(g.y() / 3) * y + T(0.5 * f0);
        if (k == 0) return {factor * turn, T(0.5) * turn, T(0.5 * stretch) * turn};
        const T dx = p.x - T(center.x()), dy = p.y - T(center.y());
        const T s = T(4 / (w * w)) * (dx * dx + dy * dy), r = T(1.0) + s;
        const T area = (s * s + T(3.0) * s + T(3.0)) / (T(3.0) * (r * sqrt(r) + T(1.0)));
        return {factor * turn, T(0.5) * turn, area * (dx * p.y1 - dy * p.x1)};
    }
    std::array<double, 3> sizes(const SpanPoint<double>& p) const {
        const Vector2d at(p.x, p.y), step(p.x1, p.y1);
        // Points are rounded by as much, and what they are off by turns with the step.
        const double noise = u * at.norm() / term_rounding;
        const double q = (at - o).norm(), turn = (q + noise) * step.norm();
        // f0 itself carries the roundings of large terms that cancel.
        const double bend = std::abs(c),
                     height = std::abs(f0) + bend * (o - center).squaredNorm() + g.norm() * o.norm();
        const double factor = bend / 4 * q * q + g.norm() * q / 3 + height / 2;
        if (k == 0) return {factor * turn, 0.5 * turn, 0.5 * stretch * turn};
        const double d = (at - center).norm();
        return {factor * turn, 0.5 * turn, std::hypot(1, 2 * d / w) * (d + noise) * step.norm()};
    }
};

// ---- Cylinders --------------------------------------------------------------------------------------

// With Z = f0 + z1 v + z2 v^2, so that f = mu Z + eps H u, and J = 1 + eps^2 v^2 / 4 the antiderivatives in u
// are
//     height:   integral of (mu Z + eps H u) mu J du
//                 = J (Z (u + eps u^2 + eps^2 u^3 / 3) + eps H (u^2 / 2 + eps u^3 / 3)),
//     chart:    J (u + eps u^2 / 2),      surface: |D| (u + eps u^2 / 2)
// where D is the cross product of the patch's derivatives P_u and P_v / mu:
//     P_u = (1 - eps^2 v^2 / 4, eps v, eps (Z + H)),   P_v / mu = (-eps v / 2, 1, z1 + 2 z2 v).
// A span's points are about the frame's origin and turned into its axes, each rounded by up to u times `far`:
// along the cylinder's axis y hardly changes, which no bound of the other coordinates would tell.
struct CylinderIntegrand {
    double far;
    double eps, f0, fall, z1, z2, side;  // fall = eps H

    CylinderIntegrand(const CylinderFrame& f, double far)
        : far(far),
          eps(f.eps()),
          f0(f.f0()),
          fall(f.fall()),
          z1(f.z1()),
          z2(f.z2()),
          side(f.height().side()) {}

    template <class T>
    std::array<T, 3> in_parameters(const T& u, const T& v, const T& v1) const {
        const T eu = T(eps) * u, ev = T(eps) * v;
        const T Z = T(f0) + (T(z1) + T(z2) * v) * v;
        const T J = T(1.0) + T(0.25) * ev * ev, half = u * (T(1.0) + T(0.5) * eu);
        const T cubic = T(1.0 / 3) * eu * eu;
        const T volume = J * u * (Z * (T(1.0) + eu + cubic) + T(fall) * u * (T(0.5) + T(1.0 / 3) * eu));
        const T ux = T(1.0) - T(0.25) * ev * ev, uy = ev, uz = T(eps) * Z + T(fall);
        const T vx = T(-0.5) * ev, vz = T(z1) + T(2 * z2) * v;
        const T nx = uy * vz - uz, ny = uz * vx - ux * vz;
        return {T(side) * volume * v1, J * half * v1, sqrt(nx * nx + ny * ny + J * J) * half * v1};
    }

    template <class T>
    std::array<T, 3> operator()(const SpanPoint<T>& p) const {
        const T &x = p.x, &y = p.y, &x1 = p.x1, &y1 = p.y1;
        // cylinder_patch.cpp: CylinderFrame::parameters
        const T qx = T(1.0) + T(eps) * x, qy = T(eps) * y;
        const T r = sqrt(qx * qx + qy * qy), mu = T(0.5) * (r + qx);
        const T u = x + T(0.25 * eps) * y * y / mu, u1 = T(0.5) * ((qx * x1 + qy * y1) / r + x1);
        const T v = y / mu, v1 = (y1 - v * T(eps) * u1) / mu;
        return in_parameters(u, v, v1);
    }
    std::array<double, 3> sizes(const SpanPoint<double>& p) const {
        const Vector2d step(p.x1, p.y1);
        const double x = p.x, y = p.y, qx = 1 + eps * x;
        const double mu = 0.5 * (std::hypot(qx, eps * y) + qx);
        const double noise = u * far / term_rounding;
        const double v = (std::abs(y) + noise) / mu, U = std::abs(x) + eps * v * v * mu / 4 + noise;
        const double v1 = step.norm() * (1 + eps * v) / mu;
        const double Z = std::abs(f0) + (std::abs(z1) + std::abs(z2) * v) * v, eu = eps * U, ev = eps * v;
        const double J = 1 + ev * ev, half = U * (1 + eu);
        const double slope = eps * Z + std::abs(fall) + std::abs(z1) + 2 * std::abs(z2) * v;
        return {J * U * (Z * (1 + eu + eu * eu) + std::abs(fall) * U * (1 + eu)) * v1, J * half * v1,
                J * (1 + slope) * half * v1};
    }
};

// About the cone's tip instead, over whose projection A the height is -H (of what a hollow one is reflected
// to: it has the other sign): with q = p - A, R = |q| and the direction n of q, f + H = (K - n.d) R / lambda
// and the surface's stretch sqrt(lambda^2 + |K n - d|^2) / lambda are known along each ray, and what lies
// between A and the span is
//     height:  ((f + H) / 3 - H / 2) q x q',    chart:  q x q' / 2,    surface: stretch q x q' / 2.
// A tube has K = 1, and 2 (1 - n.d) under the root.
// Points and A are rounded by up to u times `far`.
struct ConeIntegrand {
    double far;
    Vector2d d;
    double K, steep, depth, side;
    double wide;  // lambda^2 + |d|^2 - K^2

    /// Of spans about A.
    ConeIntegrand(const CylinderHeight& height, double far)
        : far(far),
          d(height.axis().head<2>()),
          K(height.cosine()),
          steep(height.steep()),
          depth(height.depth()),
          side(height.side()),
          wide(-2 * height.sine() * height.steep()) {}

    template <class T>
    std::array<T, 3> operator()(const SpanPoint<T>& p) const {
        const T R = sqrt(p.x * p.x + p.y * p.y), turn = p.x * p.y1 - p.y * p.x1;
        const T aslant = T(K) - (T(d.x()) * p.x + T(d.y()) * p.y) / R;
        return {(T(side / (3 * steep)) * aslant * R - T(0.5 * side * depth)) * turn, T(0.5) * turn,
                T(std::numbers::sqrt2 / (2 * steep)) * sqrt(T(K) * aslant + T(0.5 * wide)) * turn};
    }
    std::array<double, 3> sizes(const SpanPoint<double>& p) const {
        const double step = std::hypot(p.x1, p.y1), noise = u * far / term_rounding,
                     R = std::hypot(p.x, p.y) + noise;
        // The difference has the rounding of 1; and the direction turns with A.
        const double aslant = std::abs(K - (d.x() * p.x + d.y() * p.y) / R) + 1.0 / 32;
        const double stretch = sqrt(2 * aslant + std::abs(wide)) / steep,
                     turning = d.norm() / (steep * steep);
        return {(aslant * R / (3 * steep) + noise * turning + 0.5 * std::abs(depth)) * R * step,
                0.5 * R * step, 0.5 * (stretch * R + turning * noise) * step};
    }
};

template <class Integrand>
FaceIntegrals integrals(const Integrand& integrand, const PowerSpan& span) {
    std::array<Integral, 3> sum{};
    integrate(span, integrand, sum);
    return {sum[0], sum[1], sum[2]};
}

struct WallIntegrand {
    Vector2d along;

    template <class T>
    std::array<T, 1> operator()(const SpanPoint<T>& p) const {
        return {p.z * (T(along.x()) * p.x1 + T(along.y()) * p.y1)};
    }
    std::array<double, 1> sizes(const SpanPoint<double>& p) const {
        return {std::abs(p.z) * Vector2d(p.x1, p.y1).norm()};
    }
};

}  // namespace

FaceIntegrals face_integrals(const CircularForm& f, const Vector2d& origin, ControlPoints span) {
    return integrals(CircularIntegrand(f, origin), power_span(span));
}

FaceIntegrals face_integrals(const CylinderFrame& frame, double extent, ControlPoints span) {
    std::array<Eigen::Vector4d, PowerSpan::largest_degree + 1> controls;
    const std::span moved(controls.begin(), span.size());
    std::ranges::copy(span, moved.begin());
    double far = 0;
    for (const Eigen::Vector4d& p : span) far = std::max(far, p.head<2>().norm() + frame.origin().norm());
    const CylinderHeight& height = frame.height();
    if (frame.eps() * extent > 0.5) {
        const double along = (height.point().z() + height.rho()) / height.steep();
        const Vector2d tip = height.focus();
        for (Eigen::Vector4d& p : moved) p.head<2>() -= tip;
        return integrals(
            ConeIntegrand(height, 4 * (far + (height.reach() + std::abs(along)) / height.steep())),
            power_span(moved));
    }
    for (Eigen::Vector4d& p : moved) p.head<2>() = frame.turned(p.head<2>() - frame.origin());
    return integrals(CylinderIntegrand(frame, 4 * far), power_span(moved));
}

Integral space_length(ControlPoints span) { return span_integrals::length(power_span(span)); }

Integral wall_area(ControlPoints span) {
    const Vector2d chord = (span.back() - span.front()).head<2>();
    std::array<Integral, 1> sum{};
    integrate(power_span(span), WallIntegrand{chord.normalized()}, sum);
    return sum[0];
}

}  // namespace vcell
