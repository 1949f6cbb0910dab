#include "arc_equations.hpp"

namespace vcell::space_fit {

Bernstein<10> along_span(const SpaceQuadric& quadric, const Eigen::Matrix3d& axes, const Vec3& center,
                         const SpanPolynomials& span, Vector4d& sizes) {
    Bernstein<10> Q = raised<10>(0 * span.X[3] + quadric.k);
    sizes.setZero();
    for (int i = 0; i < 3; ++i) {
        const Vec3 axis = axes.row(i);
        const Bernstein<5> x = span.linear(axis, 0, axis.dot(span.foot - center));
        Q = Q + quadric.M(i, i) * vcell::square(x);
        sizes[i] = x.largest();
    }
    return Q;
}

Equation Equation::difference(const Equation& left, const Equation& right, const Vector4d& near) {
    const Vec3 way = right.point_ - left.point_,
               axis = left.axis_.dot(right.axis_) < 0 ? Vec3(-left.axis_) : left.axis_,
               tilt = right.axis_ - axis, axes = axis + right.axis_;
    const double grown = right.delta_ - left.delta_, along = axes.dot(way), aside = tilt.dot(way);
    SpaceQuadric q;
    q.M.topLeftCorner<3, 3>() = -0.5 * (tilt * axes.transpose() + axes * tilt.transpose());
    q.l << -2 * way + 0.5 * (along * axes + aside * tilt), -2 * left.kappa_ * grown;
    q.k = -grown * (left.delta_ + right.delta_) - 0.25 * along * aside;
    q = q.times(left.sense_);
    Equation e = quadric(q, near, 0.5 * (left.point_ + right.point_));
    e.delta_ = std::abs(left.delta_) + std::abs(right.delta_);
    e.reach_ = left.reach_ + right.reach_;
    // About the base, and along it, nothing is rounded.
    if (left.across(left.point_) == Vec3::Zero() && tilt == Vec3::Zero()) return e;
    e.is_rounded_ = true;
    // About the difference of the distances: over its small gradient what rounding leaves of it would
    // look like a span that is far off.
    e.scale_ = 0.5 / left.from_axis(near).norm();
    return e;
}

namespace {

// A quadric without mixed terms in axes of its own, the rows.
struct Needle {
    Eigen::Matrix3d axes;
    SpaceQuadric quadric;
};

// Where a ball is as far as the base ball, or a tube as a base tube of its direction, if one of the two
// touches the other from within but for little. With c the way between their centres or axes, its unit vector
// e, Y what is across the axes of the way from halfway between them, delta the difference of the radii, gap =
// |c|^2 - delta^2, and L = gap / 2 - c.p - delta t for points p at the distance t from the base's centre or
// axis,
//     |Y|^2 - (1 + gap / delta^2) (e.Y)^2 + gap / 4 = -2 t L / delta - L^2 / delta^2,
// and the site is met where L = 0: an arc that starts there never gets to L = -2 delta t. Gradients of
// distances would turn as far on a small part of the needle's width as they are apart, and in other axes all
// that tells its width would cancel.
Needle needle_along(const Vec3& c, const Vec3& axis, double delta, double gap) {
    const bool has_axis = !axis.isZero(0);
    const Vec3 e = c.normalized(), f = has_axis ? axis : e.unitOrthogonal();
    Needle needle;
    needle.axes << f.transpose(), e.cross(f).transpose(), e.transpose();
    needle.quadric.M.diagonal() << (has_axis ? 0 : 1), 1, -gap / square(delta), 0;
    needle.quadric.k = gap / 4;
    if (delta > 0) needle.quadric = needle.quadric.times(-1);
    return needle;
}

}  // namespace

std::optional<Equation> Equation::needle(const Equation& base, const Equation& site, const Vector4d& X) {
    constexpr double thinnest_alike = 0x1p-6, widest = 0x1p-4;
    if (!base.is_round_ || !site.is_round_ || site.kappa_ != 1 || site.sine_ > 0) return std::nullopt;
    if (site.axis_ != base.axis_ && site.axis_ != -base.axis_) return std::nullopt;
    const Vec3 a = base.from_axis(X).normalized(), b = site.from_axis(X).normalized();
    if ((a - b).norm() > thinnest_alike) return std::nullopt;
    const Vec3 c = base.across(site.point_ - base.point_);
    const double delta = site.delta_ - base.delta_,
                 gap = site.power_.value_or((c.norm() - std::abs(delta)) * (c.norm() + std::abs(delta)));
    if (!(gap > 0 && gap <= widest * square(delta))) return std::nullopt;
    const Needle needle = needle_along(c, base.axis_, delta, gap);
    Equation result;
    result.is_needle_ = true;
    result.turn_ = needle.axes;
    result.set_quadric(needle.quadric, X, 0.5 * (base.point_ + site.point_));
    result.reach_ = base.reach_ + site.reach_;
    return result;
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
