#include "arc_equations.hpp"

namespace vcell::space_fit {

std::optional<Equation> Equation::needle(const Equation& base, const Equation& site, const Vector4d& X) {
    constexpr double thinnest_alike = 0x1p-6, widest = 0x1p-4;
    if (!base.is_round_ || !site.is_round_ || site.kappa_ != 1 || site.sine_ > 0) return std::nullopt;
    if (site.axis_ != base.axis_ && site.axis_ != -base.axis_) return std::nullopt;
    const Vec3 a = base.from_axis(X), b = site.from_axis(X);
    if ((a.normalized() - b.normalized()).norm() > thinnest_alike) return std::nullopt;
    const Vec3 c = base.across(site.point_ - base.point_);
    const double length = c.norm(), delta = std::abs(site.delta_ - base.delta_),
                 gap = site.power_.value_or((length - delta) * (length + delta));
    if (!(gap > 0 && gap <= widest * square(delta))) return std::nullopt;
    // In axes of its own, as all that tells its width would cancel in others.
    const Vec3 e = c / length, f = base.axis_.isZero(0) ? e.unitOrthogonal() : base.axis_;
    SpaceQuadric q;
    q.M.diagonal() << (base.axis_.isZero(0) ? 1 : 0), 1, -gap / square(delta), 0;
    q.k = gap / 4;
    Equation result;
    result.is_needle_ = true;
    result.turn_ << f.transpose(), e.cross(f).transpose(), e.transpose();
    result.set_quadric(q.times(site.delta_ < base.delta_ ? 1 : -1), X, 0.5 * (base.point_ + site.point_));
    result.reach_ = base.reach_ + site.reach_;
    return result;
}

double Equation::needle_residual(const SpanPolynomials& span) const {
    Bernstein<10> Q = raised<10>(0 * span.X[3] + quadric_->k);
    Vector4d sizes = Vector4d::Zero();
    for (int i = 0; i < 3; ++i) {
        const Vec3 axis = turn_.row(i);
        const Bernstein<5> x = span.linear(axis, 0, axis.dot(span.foot - point_));
        Q = Q + quadric_->M(i, i) * vcell::square(x);
        sizes[i] = x.largest();
    }
    return scale_ * QuinticNodes::get().largest(Q) + rounding * terms(sizes);
}

Equation base_equation(const BaseChart& chart, const Vec3& foot) {
    if (chart.is_plane()) return Equation::plane(Vec3::Zero(), Vec3::UnitZ(), 0);
    const Vec3 axis = chart.is_sphere() ? Vec3::Zero().eval() : Vec3::UnitY().eval();
    return Equation::round(Vec3::Zero(), axis, chart.radius, chart.radius, foot);
}

namespace {

// Is the direction of the ball from the bisector's point over `foot` all but that of the base? The difference
// of the two, which tells the point, has the length |(m, c_z + rho)| / (t + rho), m = foot - c across the
// normal. Only how well the numbers are conditioned depends on this.
bool is_seen_upright(const Sphere& s, const Vec3& foot) {
    constexpr double well_told = 0x1p-6;
    const double width = s.center.z() + s.radius, m = (foot - s.center).head<2>().norm();
    const double t = 0.5 * (m * m / width + (s.center.z() - s.radius));
    return std::hypot(m, width) < well_told * (t + s.radius);
}

}  // namespace

Equation site_equation(const BaseChart& chart, const Object& site, bool is_wall, const Vec3& foot) {
    const double R0 = chart.radius;
    const Sphere* s = std::get_if<Sphere>(&site);
    if (s != nullptr && chart.is_plane() && is_seen_upright(*s, foot))
        return Equation::paraboloid(s->center, s->radius, foot);
    if (s != nullptr) return Equation::round(s->center, Vec3::Zero(), s->radius, R0, foot);
    if (const Cylinder* c = std::get_if<Cylinder>(&site))
        return Equation::round(c->point, c->axis, c->radius, R0, foot);
    // What they are away is R less the distance from the centre or the axis.
    if (const auto* vessel = std::get_if<HollowSphere>(&site))
        return Equation::round(vessel->center, Vec3::Zero(), vessel->radius, R0, foot, -1).turned();
    if (const auto* vessel = std::get_if<HollowCylinder>(&site))
        return Equation::round(vessel->point, vessel->axis, vessel->radius, R0, foot, -1).turned();
    if (const auto* vessel = std::get_if<HollowCone>(&site)) return Equation::in_cone(*vessel, R0, foot);
    const Plane& plane = std::get<Plane>(site);
    const Vec3 n = plane.normal.normalized();
    const bool inward = !is_wall && n.dot(foot - plane.point) > 0;
    return Equation::plane(plane.point, inward ? n : Vec3(-n), R0, is_wall ? 0 : 1);
}

}  // namespace vcell::space_fit
