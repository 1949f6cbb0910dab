#include "solids.hpp"

#include <optional>

namespace vcell {

namespace {

template <class T>
struct Vector {
    T x, y, z;
};

template <class T>
T dot(const Vector<T>& p, const Vector<T>& q) {
    return p.x * q.x + p.y * q.y + p.z * q.z;
}

template <class T>
Vector<T> cross(const Vector<T>& p, const Vector<T>& q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}

template <class T>
Vector<T> axis(const CylinderForm& f) {
    return {T(f.ax), T(f.ay), T(f.az)};
}

// |a|^2 (reach^2 - the squared distance of q from the axis).
template <class T>
T within_reach(const CylinderForm& f, double qx, double qy, double qz, const T& reach) {
    const Vector<T> a = axis<T>(f), m{T(qx) - T(f.px), T(qy) - T(f.py), T(qz) - T(f.pz)};
    const Vector<T> across = cross(m, a);
    return reach * reach * dot(a, a) - dot(across, across);
}

bool is_within_reach(const CylinderForm& f, double qx, double qy, double qz, double larger, double smaller) {
    if (larger < smaller) return false;
    const auto by_interval = within_reach(f, qx, qy, qz, Interval(larger) - Interval(smaller)).sign();
    if (by_interval) return *by_interval != Sign::Negative;
    return within_reach(f, qx, qy, qz, Exact(larger) - Exact(smaller)).sign() != Sign::Negative;
}

template <class T>
std::array<T, 3> axes_cross(const CylinderForm& f, const CylinderForm& g) {
    const Vector<T> c = cross(axis<T>(f), axis<T>(g));
    return {c.x, c.y, c.z};
}

bool are_parallel(const CylinderForm& f, const CylinderForm& g) {
    for (const Interval& component : axes_cross<Interval>(f, g)) {
        const std::optional<Sign> s = component.sign();
        if (s && *s != Sign::Zero) return false;
    }
    for (const Exact& component : axes_cross<Exact>(f, g))
        if (component.sign() != Sign::Zero) return false;
    return true;
}

}  // namespace

bool contains(const CylinderForm& cylinder, double cx, double cy, double cz, double rho) {
    return is_within_reach(cylinder, cx, cy, cz, cylinder.rho, rho);
}

bool contains(const CylinderForm& outer, const CylinderForm& inner) {
    return outer.rho >= inner.rho && are_parallel(outer, inner) &&
           is_within_reach(outer, inner.px, inner.py, inner.pz, outer.rho, inner.rho);
}

bool is_beside(const CylinderForm& cylinder, double cx, double cy, double cz, double rho) {
    const auto by_interval =
        within_reach(cylinder, cx, cy, cz, Interval(cylinder.rho) + Interval(rho)).sign();
    if (by_interval) return *by_interval != Sign::Positive;
    return within_reach(cylinder, cx, cy, cz, Exact(cylinder.rho) + rho).sign() != Sign::Positive;
}

bool is_beside(const CylinderForm& cylinder, const CylinderForm& other) {
    return is_beside(cylinder, other.px, other.py, other.pz, other.rho) && are_parallel(cylinder, other);
}

bool is_beyond(const std::array<Exact, 4>& plane, const CylinderForm& cylinder) {
    const Vector<Exact> n{plane[0], plane[1], plane[2]};
    if (dot(n, axis<Exact>(cylinder)).sign() != Sign::Zero) return false;
    const Exact value = dot(n, Vector<Exact>{cylinder.px, cylinder.py, cylinder.pz}) + plane[3];
    if (value.sign() == Sign::Positive) return false;
    const Exact rho(cylinder.rho);
    return (value * value - rho * rho * dot(n, n)).sign() != Sign::Negative;
}

CylinderTrace trace_on_base(const CylinderForm& form) {
    // C = M |m|^2 - |a|^2 rho^2 - (m . a)^2 with m = (x, y, 0) - p, so m . a = ax x + ay y - p . a. Lengths
    // are times the exact form's unit s.
    const ExactCylinder f = exact_cylinder(form);
    const Vector<Exact> a{f.ax, f.ay, f.az}, p{f.px, f.py, f.pz};
    const Exact norm = dot(a, a), M = norm - f.sine * f.sine, along = dot(p, a), &s = f.unit, ss = s * s;
    return {ss * (M - a.x * a.x),        -(ss * a.x * a.y),
            ss * (M - a.y * a.y),        s * (along * a.x - M * p.x),
            s * (along * a.y - M * p.y), M * dot(p, p) - norm * f.rho * f.rho - along * along,
            {s * a.x, s * a.y, -along}};
}

}  // namespace vcell
