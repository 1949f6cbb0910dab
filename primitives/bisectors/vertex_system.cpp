#include "vertex_system.hpp"

#include <algorithm>
#include <limits>

namespace vcell {

namespace {

template <class T>
using Forms = QuadraticForms<4, T>;

std::array<double, 3> to_array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

template <class T>
T squared_norm(const std::array<double, 3>& v) {
    T sum(0.0);
    for (const double x : v) sum += square(T(x));
    return sum;
}

template <class T>
void write(Forms<T>& f, int k, const PlaneSite& s) {
    f.constant[k] = T(s.offset);
    for (int i = 0; i < 3; ++i) {
        f.linear[i][k] = T(s.normal[i]);
        f.constant[k] -= T(s.normal[i]) * T(s.point[i]);
    }
    f.linear[3][k] = -sqrt(squared_norm<T>(s.normal));
}

template <class T>
void write(Forms<T>& f, int k, const BoxSideSite& s) {
    f.linear[s.axis][k] = T(1.0);
    f.constant[k] = -T(s.bound);
}

template <class T>
void write(Forms<T>& f, int k, const RimSite& s) {
    const T norm = sqrt(squared_norm<T>(s.base.normal));
    f.linear[s.side.axis][k] = norm;
    f.linear[3][k] = -T(s.base.normal[s.side.axis]);
    f.constant[k] = -(norm * T(s.side.bound));
}

template <class T>
void write(Forms<T>& f, int k, const SphereSite& s) {
    const T rho(s.radius);
    T constant = -square(rho);
    for (int i = 0; i < 3; ++i) {
        const T c(s.center[i]);
        f.quadratic[f.pair(i, i)][k] = T(1.0);
        f.linear[i][k] = T(-2.0 * s.center[i]);
        constant += square(c);
    }
    f.quadratic[f.pair(3, 3)][k] = T(-1.0);
    f.linear[3][k] = T(-2.0 * s.radius);
    f.constant[k] = constant;
}

// With D = |d|^2 I - d d^T: p^T D p - 2 (D c).p + c^T D c = |d|^2 (r + rho)^2.
template <class T>
void write(Forms<T>& f, int k, const CylinderSite& s) {
    const T norm2 = squared_norm<T>(s.direction);
    std::array<std::array<T, 3>, 3> D;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const T dd = T(s.direction[i]) * T(s.direction[j]);
            D[i][j] = i == j ? norm2 - dd : -dd;
        }
    T constant = -(norm2 * square(T(s.radius)));
    for (int i = 0; i < 3; ++i) {
        T Dc(0.0);
        for (int j = 0; j < 3; ++j) Dc += D[i][j] * T(s.point[j]);
        f.quadratic[f.pair(i, i)][k] = D[i][i];
        for (int j = i + 1; j < 3; ++j) f.quadratic[f.pair(i, j)][k] = D[i][j] + D[i][j];
        f.linear[i][k] = -(Dc + Dc);
        constant += Dc * T(s.point[i]);
    }
    f.quadratic[f.pair(3, 3)][k] = -norm2;
    f.linear[3][k] = -(norm2 * T(2.0 * s.radius));
    f.constant[k] = constant;
}

// D.(M D) + 2 slant radius |d| (d.D) r - slant^2 |d|^2 r^2 = 0, where D = p - c and
// M = (slant^2 - radius^2) |d|^2 I - slant^2 d d^T: (cos |D|)^2 is that of D across d, and that along it less
// the sine's square.
template <class T>
void write(Forms<T>& f, int k, const ConeSite& s) {
    const T norm2 = squared_norm<T>(s.direction), slant2 = square(T(s.slant)),
            rest = (slant2 - square(T(s.radius))) * norm2,
            lean = T(2.0) * T(s.slant) * T(s.radius) * sqrt(norm2);
    T constant(0.0), apex_along(0.0);
    for (int i = 0; i < 3; ++i) {
        const T d(s.direction[i]);
        T of_apex = rest * T(s.apex[i]);
        for (int j = 0; j < 3; ++j) of_apex -= slant2 * d * T(s.direction[j]) * T(s.apex[j]);
        f.quadratic[f.pair(i, i)][k] = rest - slant2 * square(d);
        for (int j = i + 1; j < 3; ++j)
            f.quadratic[f.pair(i, j)][k] = -(T(2.0) * slant2 * d * T(s.direction[j]));
        f.quadratic[f.pair(i, 3)][k] = lean * d;
        f.linear[i][k] = -(of_apex + of_apex);
        constant += of_apex * T(s.apex[i]);
        apex_along += d * T(s.apex[i]);
    }
    f.quadratic[f.pair(3, 3)][k] = -(slant2 * norm2);
    f.linear[3][k] = -(lean * apex_along);
    f.constant[k] = constant;
}

template <class T>
void write(Forms<T>& f, int k, const EndSite& s) {
    const CylinderSite& tube = s.tube;
    const int axis = s.side.axis;
    std::array<double, 3> across = tube.direction;
    across[axis] = 0;
    const T norm2 = squared_norm<T>(tube.direction),
            reach = T(tube.radius) * sqrt(squared_norm<T>(across) / norm2),
            middle = T(s.side.bound) + (s.from_below ? -reach : reach);
    f.constant[k] = -((middle - T(tube.point[axis])) * norm2);
    for (int i = 0; i < 3; ++i) {
        f.linear[i][k] = T(tube.direction[axis]) * T(tube.direction[i]);
        f.constant[k] -= f.linear[i][k] * T(tube.point[i]);
    }
}

}  // namespace

PlaneSite vertex_site(const Plane& plane, const Vec3& inside) {
    const Vec3 n = plane.normal.dot(inside - plane.point) < 0 ? Vec3(-plane.normal) : plane.normal;
    return {to_array(n), 0, to_array(plane.point)};
}
SphereSite vertex_site(const Sphere& sphere, const Vec3&) { return {to_array(sphere.center), sphere.radius}; }
CylinderSite vertex_site(const Cylinder& tube, const Vec3&) {
    return {to_array(tube.point), to_array(tube.axis), tube.radius};
}
// r = R - d is the root of d^2 = (r - R)^2 that is no more than R.
SphereSite vertex_site(const HollowSphere& vessel, const Vec3&) {
    return {to_array(vessel.center), -vessel.radius};
}
CylinderSite vertex_site(const HollowCylinder& vessel, const Vec3&) {
    return {to_array(vessel.point), to_array(vessel.axis), -vessel.radius};
}
ConeSite vertex_site(const HollowCone& vessel, const Vec3&) {
    return {to_array(vessel.apex), to_array(vessel.axis), vessel.radius, vessel.slant};
}
VertexSite vertex_site(const Object& object, const Vec3& inside) {
    return std::visit([&](const auto& o) -> VertexSite { return vertex_site(o, inside); }, object);
}

template <class T>
QuadraticForms<4, T> VertexSystem::forms() const {
    Forms<T> f;
    for (int k = 0; k < 4; ++k) std::visit([&](const auto& site) { write(f, k, site); }, sites[k]);
    return f;
}

template QuadraticForms<4, Interval> VertexSystem::forms<Interval>() const;
template QuadraticForms<4, Wide> VertexSystem::forms<Wide>() const;

double VertexSystem::least_clearance() const {
    double least = -std::numeric_limits<double>::infinity();
    for (const VertexSite& site : sites) {
        if (const auto* s = std::get_if<SphereSite>(&site); s && s->radius >= 0)
            least = std::max(least, -s->radius);
        if (const auto* c = std::get_if<CylinderSite>(&site); c && c->radius >= 0)
            least = std::max(least, -c->radius);
    }
    return least;
}

}  // namespace vcell
