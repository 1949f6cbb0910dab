#include "space_chart.hpp"

#include <cmath>

namespace vcell::space_fit {

Vector4d SpaceChart::with_distance(const Vec3& p) const {
    Vector4d X;
    X << p, is_plane() ? p.z() : kind_ == Kind::Sphere ? p.norm() : std::hypot(p.x(), p.z());
    return X;
}

Equation SpaceChart::base_equation(const Vec3& foot) const {
    if (is_plane()) return Equation::plane(Vec3::Zero(), Vec3::UnitZ(), 0);
    const Vec3 axis = kind_ == Kind::Sphere ? Vec3::Zero().eval() : Vec3::UnitY().eval();
    return Equation::round(Vec3::Zero(), axis, radius(), radius(), foot);
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

Equation SpaceChart::equation(const SpaceSite& site, const Vec3& foot) const {
    const double R0 = radius();
    const Sphere* s = std::get_if<Sphere>(&site.object);
    if (s != nullptr && is_plane() && is_seen_upright(*s, foot))
        return Equation::paraboloid(s->center, s->radius, foot);
    if (s != nullptr) return Equation::round(s->center, Vec3::Zero(), s->radius, R0, foot);
    if (const Cylinder* c = std::get_if<Cylinder>(&site.object))
        return Equation::round(c->point, c->axis, c->radius, R0, foot);
    const Plane& plane = std::get<Plane>(site.object);
    const Vec3 n = plane.normal.normalized();
    const bool inward = !site.is_wall && n.dot(foot - plane.point) > 0;
    return Equation::plane(plane.point, inward ? n : Vec3(-n), R0, site.is_wall ? 0 : 1);
}

Vec3 SpaceChart::normal_derivative(const Vec2& q, const Vec2& d) const {
    if (is_plane()) return Vec3::Zero();
    if (kind_ == Kind::Cylinder) {
        const bool back = q.x() > 1;
        const double a = back ? q.x() - 2 : q.x(), W = 1 + a * a;
        return (back ? -2 : 2) * d.x() / (W * W) * (problem_->chart * Vec3(1 - a * a, 0, -2 * a));
    }
    const double W = 1 + q.squaredNorm(), dW = 2 * q.dot(d);
    const Vec3 n(2 * q.x(), 2 * q.y(), 1 - q.squaredNorm());
    return problem_->chart * (Vec3(2 * d.x(), 2 * d.y(), -dW) / W - n * (dW / (W * W)));
}

Vec2 SpaceChart::continued(Vec2 q, const std::array<double, 4>& box) const {
    if (kind_ != Kind::Cylinder) return q;
    const double middle = 0.5 * (box[0] + box[1]);
    if (q.x() - middle > 2) q.x() -= 4;
    if (middle - q.x() > 2) q.x() += 4;
    return q;
}

}  // namespace vcell::space_fit
