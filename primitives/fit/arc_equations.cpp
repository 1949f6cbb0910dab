#include "arc_equations.hpp"

namespace vcell::space_fit {

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
