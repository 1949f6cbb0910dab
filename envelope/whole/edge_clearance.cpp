#include "edge_clearance.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/wide.hpp"

namespace vcell::whole {

namespace {

template <class T>
using Vector = std::array<T, 3>;

template <class T>
Vector<T> operator-(const Vector<T>& a, const Vector<T>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
T dot(const Vector<T>& a, const Vector<T>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
Vector<T> cross(const Vector<T>& a, const Vector<T>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
Vector<T> vector(const Vec3& v) {
    return {T(v.x()), T(v.y()), T(v.z())};
}
Vector<Interval> around(const EdgePoint& p) {
    return {Interval::ball(p.point.x(), p.error), Interval::ball(p.point.y(), p.error),
            Interval::ball(p.point.z(), p.error)};
}

// Seen from the first centre let u, v be the other two, d the excesses of their radii over the first one's, t
// the clearance plus the first radius. A point x is equally clear of the three where |x| = t, |x - u| = t +
// d_u and |x - v| = t + d_v; less the first, squared, the other two say
//     u.x = k_u - d_u t,  v.x = k_v - d_v t,  k_u = (|u|^2 - d_u^2) / 2.
// In the plane of the centres x = a u + b v, with (a, b) G = (u.x, v.x) and G the matrix of products of u and
// v. With D = det G = |u x v|^2 and <p, q> = D p G^-1 q, |x|^2 = t^2 becomes
//     (D - <d, d>) t^2 + 2 <k, d> t - <k, k> = 0.
// The trisector is symmetric about that plane. D > <d, d>: it is a branch of a hyperbola, or a line; the one
// positive root is its narrowest point, and t grows with the distance from the plane. D < <d, d>: an ellipse,
// of which the smaller root is the narrowest point and the larger one the widest.
template <class T>
struct Narrowest {
    Vector<T> u, v;
    T du, dv, ku, kv, uu, uv, vv, D, open;  // open = D - <d, d>

    explicit Narrowest(const std::array<Sphere, 3>& balls) {
        const Vector<T> origin = vector<T>(balls[0].center);
        u = vector<T>(balls[1].center) - origin;
        v = vector<T>(balls[2].center) - origin;
        du = T(balls[1].radius) - T(balls[0].radius);
        dv = T(balls[2].radius) - T(balls[0].radius);
        uu = dot(u, u);
        uv = dot(u, v);
        vv = dot(v, v);
        const Vector<T> n = cross(u, v);
        D = dot(n, n);
        open = D - product(du, dv, du, dv);
    }
    T product(const T& pu, const T& pv, const T& qu, const T& qv) const {
        return vv * pu * qu - uv * (pu * qv + pv * qu) + uu * pv * qv;
    }
    /// t in the narrowest point; none where this precision does not enclose it.
    std::optional<T> root() {
        ku = T(0.5) * (uu - du * du);
        kv = T(0.5) * (vv - dv * dv);
        const T b = product(ku, kv, du, dv), c = product(ku, kv, ku, kv), square_of_root = b * b + open * c;
        if (!(square_of_root.upper() >= 0)) return std::nullopt;
        const T root = sqrt(square_of_root);
        // Of two forms of it the one in which nothing cancels.
        if (const T sum = b + root; b.lower() >= 0 && sum.lower() > 0) return c / sum;
        if (open.lower() > 0) return (root - b) / open;
        if (const T sum = b + root; sum.lower() > 0) return c / sum;
        return std::nullopt;
    }
    /// The place of it, seen from the first centre. Pre: D > 0.
    Vector<T> place(const T& t) const {
        const T pu = ku - du * t, pv = kv - dv * t;
        const T a = (vv * pu - uv * pv) / D, b = (uu * pv - uv * pu) / D;
        return {a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]};
    }
};

Interval narrowed(const Interval& x) { return x; }
Interval narrowed(const Wide& x) { return x.enclosure(); }

struct Shape {
    bool is_collinear = false;  // centres on a line: the trisector is a circle of one clearance
    bool is_ellipse = false;
};

Shape shape_of(const std::array<Sphere, 3>& balls) {
    const Narrowest<Interval> fast(balls);
    if (fast.D.lower() > 0 && fast.open.sign()) return {false, fast.open.upper() < 0};
    const Narrowest<Exact> exact(balls);
    return {exact.D.sign() == Sign::Zero, exact.open.sign() == Sign::Negative};
}

struct Narrow {
    Interval clearance;
    Vector<Interval> place;  // world
};

template <class T>
std::optional<Narrow> narrowest(const std::array<Sphere, 3>& balls) {
    Narrowest<T> problem(balls);
    if (!(problem.D.lower() > 0)) return std::nullopt;
    const std::optional<T> t = problem.root();
    if (!t) return std::nullopt;
    const Vector<T> place = problem.place(*t);
    Narrow result;
    result.clearance = narrowed(*t - T(balls[0].radius));
    for (int k = 0; k < 3; ++k)
        result.place[static_cast<std::size_t>(k)] =
            narrowed(place[static_cast<std::size_t>(k)] + T(balls[0].center[k]));
    return result;
}

// Is the narrowest point on the arc? None: the errors do not tell.
std::optional<bool> is_on_arc(const std::array<Sphere, 3>& balls, const EdgeArc& arc, const Shape& shape,
                              const Narrow& narrow) {
    if (arc.is_closed) return true;
    const Vector<Interval> a = around(arc.ends[0]), b = around(arc.ends[1]);
    if (shape.is_ellipse) {
        // A chord cuts a convex curve into two arcs, one on either side: that of `middle` is this one.
        const Vector<Interval> chord = b - a;
        const Interval side = dot(cross(chord, around(arc.middle) - a), cross(chord, narrow.place - a));
        if (const auto sign = side.sign(); sign && *sign != Sign::Zero) return *sign == Sign::Positive;
        return std::nullopt;
    }
    // An open trisector comes through the plane of the centres once.
    const Vector<Interval> origin = vector<Interval>(balls[0].center);
    const Vector<Interval> n =
        cross(vector<Interval>(balls[1].center) - origin, vector<Interval>(balls[2].center) - origin);
    const auto first = dot(n, a - origin).sign(), second = dot(n, b - origin).sign();
    if (!first || !second) return std::nullopt;
    return *first != *second;
}

}  // namespace

std::optional<Interval> least_clearance(const std::array<Sphere, 3>& balls, const EdgeArc& arc) {
    const auto end = [&](int i) {
        return Interval::ball(arc.ends[static_cast<std::size_t>(i)].clearance,
                              arc.ends[static_cast<std::size_t>(i)].error);
    };
    const Interval first = end(0), second = end(1),
                   lesser{std::min(first.lower(), second.lower()), std::min(first.upper(), second.upper())};
    const Shape shape = shape_of(balls);
    if (shape.is_collinear) return lesser;
    // Beyond this part of its size, an enclosure in doubles is not good enough.
    constexpr double good = 0x1p-36;
    std::optional<Narrow> narrow = narrowest<Interval>(balls);
    const double size = std::abs(arc.ends[0].clearance) + balls[0].radius;
    if (!narrow || !(narrow->clearance.width() <= good * size)) narrow = narrowest<Wide>(balls);
    if (!narrow) return std::nullopt;
    const std::optional<bool> is_on = is_on_arc(balls, arc, shape, *narrow);
    if (is_on && !*is_on) return lesser;
    // No point of the trisector is narrower; and one of the arc's is no wider than its ends.
    const Interval inner{narrow->clearance.lower(), std::min(narrow->clearance.upper(), lesser.upper())};
    if (is_on) return inner.lower() <= inner.upper() ? inner : narrow->clearance;
    double low = std::min(inner.lower(), lesser.upper());
    // Clearances change no faster than places.
    if (arc.length) {
        const Interval sum = Interval(0.5) * (first + second - Interval(*arc.length));
        low = std::max(low, std::min(sum.lower(), lesser.upper()));
    }
    return Interval(low, lesser.upper());
}

}  // namespace vcell::whole
