#include "cylinder_patch.hpp"

#include <cmath>
#include <limits>

namespace vcell {

using Eigen::Vector2d;
using Eigen::Vector3d;

CylinderHeight::CylinderHeight(const CylinderForm& form, const Vector2d& near)
    : c_(form.px, form.py, form.pz), d_(form.ax, form.ay, form.az), rho_(form.rho) {
    if (form.is_hollow()) {
        side_ = -1;
        c_.z() = -c_.z();
        d_.z() = -d_.z();
        rho_ = -rho_;
    }
    const double length = d_.stableNorm();
    sine_ = side_ * form.sine / length;
    cosine_ = std::sqrt((1 - sine_) * (1 + sine_));
    steep_ = side_ * form.steep() / length;
    d_ = d_.stableNormalized();
    if (steep_ < 0) {
        d_ = -d_;
        sine_ = -sine_;
        steep_ = -steep_;
    }
    reach_ = c_.norm();
    if (form.is_cone()) return;
    const double shift = (Vector3d(near.x(), near.y(), 0) - c_).dot(d_);
    reach_ += std::abs(shift);
    c_ += shift * d_;
}

// With m = (p, 0) - c and the derivative of C - 2 beta f - lambda^2 f^2 = 0:
//     (grad C - 2 f grad beta) / 2 = K s grad f,   grad C / 2 = K^2 m - (m.d) d,   grad beta = lambda d,
// which needs no division by lambda.
CylinderHeight::Jet CylinderHeight::operator()(const Vector2d& p) const {
    const Vector2d d = d_.head<2>(), m = p - c_.head<2>();
    const double dz = d_.z(), K2 = cosine_ * cosine_, along = m.dot(d) - c_.z() * dz;
    const Vector2d v = steep_ * m + (rho_ + c_.z()) * d;
    const double s = v.norm(), root = cosine_ * s, beta = rho_ + K2 * c_.z() + along * steep_;
    // What is across the axis alone: next to it |m|^2 - (m.d)^2 would cancel.
    const double up = c_.z() + along * dz;
    const double across = (m - along * d).squaredNorm();
    const double C = sine_ == 0 ? across + (up - rho_) * (up + rho_)
                                : K2 * (across + up * up) - sine_ * sine_ * along * along;
    const double f = beta < 0 ? (root - beta) / (steep_ * steep_) : C / (root + beta);
    return {side_ * f, side_ * (K2 * m - (along + steep_ * f) * d) / root, v, s};
}

double CylinderHeight::curvature_bound(double s, double radius) const {
    const double smallest = s - steep_ * radius;  // |grad s| = lambda
    return smallest > 0 ? cosine_ / smallest : std::numeric_limits<double>::infinity();
}

// K V / s - d has a length of at most K + |d|.
double CylinderHeight::slope_bound(const Jet& at, double radius) const {
    const double anywhere = (cosine_ + d_.head<2>().norm()) / steep_;
    return std::min(anywhere, at.gradient.norm() + radius * curvature_bound(at.s, radius));
}

CylinderFrame::CylinderFrame(const CylinderForm& form, const Vector2d& p0) : height_(form, p0), origin_(p0) {
    const CylinderHeight::Jet jet = height_(p0);
    e_ = jet.v / jet.s;
    eps_ = height_.steep() / jet.s;
    f0_ = height_.side() * jet.value;
    fall_ = eps_ * height_.rho() + height_.sine() * height_.point().z() / jet.s;
    z1_ = height_.side() * turned(jet.gradient).y();
    z2_ = (height_.cosine() + height_.axis().head<2>().dot(e_)) / (4 * jet.s);
}

// With q = (1 + eps x, eps y) for p - p0 = (x, y) in the frame, and r = |q|:
//     mu = (r + q_x) / 2,   u = x + eps y^2 / (4 mu),   v = y / mu.
Vector2d CylinderFrame::parameters(const Vector2d& p) const {
    const Vector2d a = turned(p - origin_), q(1 + eps_ * a.x(), eps_ * a.y());
    const double r = q.norm(), mu = q.x() < 0 ? 0.5 * q.y() * q.y() / (r - q.x()) : 0.5 * (r + q.x());
    return {a.x() + eps_ * a.y() * a.y() / (4 * mu), a.y() / mu};
}

// On the patch lambda^2 (f + H) = K s - d.V(p), V(p) = V(p0) + lambda (p - p0) and r = s / s0, so that with
// mu = (r + q_x) / 2 = 1 + eps u
//     u = (x + (s - s0) / lambda) / 2 = (x + (d.(p - p0) + lambda (f - f0)) / K) / 2,
// which is linear in (p, f), and v = y / mu. It holds for lambda = 0, too: there d = K e and u = x.
PatchCoordinates CylinderFrame::coordinates() const {
    const double K = height_.cosine(), up = 0.5 * height_.steep() / K;
    const Vector2d along = 0.5 * (e_ + height_.axis().head<2>() / K), left(-e_.y(), e_.x());
    PatchCoordinates c;
    c[0].numerator << along, height_.side() * up, 0, -along.dot(origin_) - up * f0_;
    c[1].numerator << left, 0, 0, -left.dot(origin_);
    c[1].divisor = eps_ * c[0].numerator + PatchCoordinate::Linear::Unit(4);
    return c;
}

// Blossoms: v^2 -> v v', v -> (v + v') / 2.
RationalPatch CylinderFrame::patch(const std::array<double, 2>& u, const std::array<double, 2>& v,
                                   const BaseFrame& frame) const {
    RationalPatch surface;
    surface.degree_u = 1;
    surface.degree_v = 2;
    surface.domain_u = u;
    surface.domain_v = v;
    for (int i = 0; i <= 1; ++i) {
        for (int j = 0; j <= 2; ++j) {
            const double m = mu(u[i]), mean = 0.5 * (v[j > 0] + v[j > 1]), square = v[j > 0] * v[j > 1];
            const Vector2d p = origin_ + turned_back({u[i] - m * eps_ * square / 4, m * mean});
            const double z = f0_ + rise() * u[i] + m * (z1_ * mean + z2_ * square);
            const Vec3 world = frame.to_world({p.x(), p.y(), height_.side() * z});
            surface.points.push_back({world.x(), world.y(), world.z(), 1});
        }
    }
    return surface;
}

}  // namespace vcell
