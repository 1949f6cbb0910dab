#include "radial_integrals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "../lift/joined_spans.hpp"
#include "../lift/radial_patch.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;
using radial_integrals::Ray;
using radial_integrals::Share;
using span_integrals::integrate_estimated;
using span_integrals::PowerSpan;
using span_integrals::SpanPoint;
using span_integrals::term_rounding;
using std::sqrt;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Rounding of a coordinate, as a part of it, in units of term_rounding.
constexpr double noise = std::numeric_limits<double>::epsilon() / 2 / term_rounding;

using Vector = std::array<double, 3>;

double dot(const Vec3& a, const Vector& b) { return a.x() * b[0] + a.y() * b[1] + a.z() * b[2]; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double norm(const Vector& a) { return sqrt(dot(a, a)); }

// d theta on a cylinder: x = sin, z = cos.
double turn(const Ray& ray) { return ray.u[2] * ray.du[0] - ray.u[0] * ray.du[2]; }

Ray ray_to(const SpanPoint<double>& p, bool is_sphere) {
    const double y = is_sphere ? p.y : 0.0, y1 = is_sphere ? p.y1 : 0.0;
    const double reciprocal = 1.0 / sqrt(p.x * p.x + y * y + p.z * p.z);
    Ray ray{{p.x * reciprocal, y * reciprocal, p.z * reciprocal}, {}, is_sphere ? 0.0 : p.y};
    const Vector d{p.x1, y1, p.z1};
    const double along = dot(ray.u, d);
    for (int i = 0; i < 3; ++i) ray.du[i] = (d[i] - ray.u[i] * along) * reciprocal;
    return ray;
}

// The integral of (K + x^2) sqrt(E2 + x^2) over 0 <= x <= v, by asinh(v / E), and the sum of the absolute
// values of its terms.
double tube_area(double K, double E2, double v) {
    const double s = sqrt(E2 + v * v), common = v * s + E2 * std::asinh(v / sqrt(E2));
    return (0.5 * K - 0.125 * E2) * common + 0.25 * v * s * s * s;
}
double tube_area_size(double K, double E2, double v) {
    const double s2 = E2 + v * v, s = sqrt(s2), far = std::abs(v);  // asinh x < x
    return far * s * (K + 0.25 * (E2 + s2));
}
// The same over first <= x <= v.
double tube_area(double K, double E2, double first, double v) {
    return first == 0 ? tube_area(K, E2, v) : tube_area(K, E2, v) - tube_area(K, E2, first);
}
double tube_area_size(double K, double E2, double first, double v) {
    const double most2 = std::max(first * first, v * v);
    return first == 0 ? tube_area_size(K, E2, v)
                      : (std::abs(v - first) + noise * std::abs(first)) * (K + most2) * sqrt(E2 + most2);
}

// The integral of (K + x^2)^2 over 0 <= x <= v.
double tube_square(double K, double v) {
    const double v2 = v * v;
    return v * (K * K + v2 * (2 * K / 3 + 0.2 * v2));
}
double tube_square(double K, double first, double v) { return tube_square(K, v) - tube_square(K, first); }
double tube_square_size(double K, double first, double v) {
    const double most = K + std::max(first * first, v * v);
    return (std::abs(v - first) + noise * std::abs(first)) * most * most;
}

}  // namespace

namespace radial_integrals {

// ---- Surfaces of revolution over a sphere -----------------------------------------------------------

// d omega = dz d phi, and d phi = b.(u x du) / (1 - z^2) = b.(p x dp) / (t^2 (1 - z^2)). With t = k / (e0 +
// e1 z) for any multiples, e1 dz = -k dt / t^2 and e1 (1 - z) = k (t - d1) / (t d1), so
//
//     integral of t^3 / 3 from z to 1 = k (t^2 - d1^2) / (6 e1) = t d1 (t + d1) (1 - z) / 6,
//     V: t d1 (t + d1) / (6 (1 + z)) b.(u x du) = d1 (t + d1) / (6 (t + b.p)) b.(p x dp),
//
// and t + b.p = 2 d1 (t + d2) / c, as on the bisector |p|^2 - 2 c b.p + c^2 = (t + delta)^2. The area element
// over dz d phi is t sqrt(t^2 + t_alpha^2), t_alpha^2 = (1 - z^2) t'(z)^2, which becomes
//
//     integral from d1 to t of 2 sqrt(d1 d2) / c sqrt(x (x + delta)) dx = 2 sqrt(d1 d2) / c (t - d1) M(t).
RoundFace::RoundFace(const RadialBaseProblem& problem, FormId form) {
    const Object& object = problem.objects[form];
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        delta = sphere->radius - problem.radius;
        c = sphere->center.norm();
        axis = sphere->center / c;
        // d1 d2 is known to rounding though one of them may be next to nothing.
        const double power = ball_power(problem, form);
        d1 = delta > 0 ? 0.5 * power / (c + delta) : 0.5 * (c - delta);
        d2 = delta > 0 ? 0.5 * (c + delta) : 0.5 * power / (c - delta);
        root = 0.5 * sqrt(power);
        shape = delta == 0 ? Shape::Flat : Shape::Hyperboloid;
        k = 0.5 * power;
        e0 = delta;
        e1 = c;
        return;
    }
    const auto& plane = std::get<Plane>(object);
    axis = plane.normal.normalized();
    double distance = axis.dot(plane.point);
    if (distance < 0) {
        axis = -axis;
        distance = -distance;
    }
    delta = 0;
    e1 = 1;
    if (problem.sites[form].front().is_object()) {
        shape = Shape::Paraboloid;
        k = distance + problem.radius;
        e0 = 1;
        d1 = 0.5 * k;
    } else {
        shape = Shape::Flat;
        k = d1 = distance;
        e0 = 0;
    }
    d2 = root = d1;
    c = 2 * d1;
}

double RoundFace::distance(const Ray& ray) const { return k / (e0 + e1 * dot(axis, ray.u)); }

// The form f(t) b.(p x dp) has the derivative f' dt ^ b.(p x dp) + f b.(dp x dp), of size t |f'| + 2 f at
// most. Of a hyperboloid, c (t + d1) / (12 (t + d2)) has t |f'| < c |delta| / (12 (t + d2)), and lies between
// its values at the ends of a stretch.
double RoundFace::volume_slope(double near, double far) const {
    switch (shape) {
        case Shape::Flat: return d1 / 3;
        case Shape::Paraboloid: return (3 * far + 2 * d1) / 12;
        case Shape::Hyperboloid: break;
    }
    const double most = std::max((near + d1) / (near + d2), (far + d1) / (far + d2));
    return c / 12 * (2 * most + std::abs(delta) / (near + d2));
}

static double largest(double x) { return x; }
template <class Derived>
double largest(const Eigen::ArrayBase<Derived>& x) {
    return x.maxCoeff();
}

// atanh(y) / y - 1, by its series up to y^2 = 1 / 16, relative truncation 2^-43 and less; from there on by
// 2 atanh(z) = atanh(y) with z = y / (1 + sqrt(1 - y^2)), y = 2 z / (1 + z^2).
template <class T>
static T atanh_excess(const T& square, int halvings = 8) {
    if (!(largest(square) > 0.0625) || halvings == 0)
        return square *
               (1.0 / 3 +
                square *
                    (1.0 / 5 +
                     square *
                         (1.0 / 7 +
                          square *
                              (1.0 / 9 +
                               square * (1.0 / 11 +
                                         square * (1.0 / 13 +
                                                   square * (1.0 / 15 +
                                                             square * (1.0 / 17 +
                                                                       square * (1.0 / 19 +
                                                                                 square * (1.0 / 21))))))))));
    const T root = 1 + sqrt(1 - square);
    const T half = square / (root * root), excess = atanh_excess(half, halvings - 1);
    return excess + half * (1 + excess);
}

// With r = sqrt(x (x + delta)) the antiderivative is (2 x + delta) r / 4 - delta^2 / 4 log(sqrt(x) + sqrt(x +
// delta)). Let r0 = sqrt(d1 d2) be that at d1 and y = (t - d1) / (r0 + r): the logarithms' difference is
// atanh(y), and as r^2 - r0^2 = (t - d1) (t + d2),
//
//     M = (2 r + (c (t + d2) - delta^2 atanh(y) / y) / (r0 + r)) / 4,
//
// c (t + d2) - delta^2 = d2 (3 d1 + t) + d1 (t - d1). What is left to subtract, delta^2 times the excess of
// atanh(y) / y over 1, is half of that at most.
template <class T>
RoundFace::Factors<T> RoundFace::factors(const T& t) const {
    switch (shape) {
        case Shape::Flat: return {T(0 * t + d1 / 6), T(0 * t + 0.5)};
        case Shape::Paraboloid: {
            const T x = sqrt(t * (1 / d1));  // the mean of sqrt(x / d1) / 2
            return {T((t + d1) * (1.0 / 12)), T((x * x + x + 1) / (3 * (x + 1)))};
        }
        case Shape::Hyperboloid: break;
    }
    const T r = sqrt(t * (t + delta)), reciprocal = 1 / (root + r), y = (t - d1) * reciprocal;
    const T over = 1 / (t + d2), rest = d2 * (3 * d1 + t) + d1 * (t - d1);
    const T mean = 2 * r + reciprocal * (rest - delta * delta * atanh_excess(T(y * y)));
    return {T(c / 12 * (t + d1) * over), T(c / (8 * root) * mean * over)};
}

// Bounds of both factors where t stays off the cut.
static Share factor_bounds(const RoundFace& f, double least, double most) {
    using Shape = RoundFace::Shape;
    if (f.shape == Shape::Flat) return {f.d1 / 6, 0.5};
    most = std::max(most, f.d1);
    if (!(least > std::max(0.0, -f.delta))) return {infinity, infinity};
    if (f.shape == Shape::Paraboloid) return {(most + f.d1) / 12, 0.5 * sqrt(most / f.d1)};
    const double scale = f.c / (least + f.d2);
    return {scale / 12 * (most + f.d1), scale * sqrt(most * (most + std::abs(f.delta))) / (2 * f.root)};
}

Share RoundFace::share(const Ray& ray) const {
    const double t = distance(ray), element = t * t * dot(axis, cross(ray.u, ray.du));
    const Factors<double> f = factors(t);
    return {f.volume * element, f.area * element};
}

Share RoundFace::size(const Ray& ray) const {
    const double t = distance(ray), condition = 1 + (std::abs(e0) + e1) * t / k;
    const double element = t * t * norm(ray.du) * condition;
    const Factors<double> f = factors(t);
    return {f.volume * element, f.area * element};
}

// ---- Cylinders over a sphere ------------------------------------------------------------------------

TubeFace::TubeFace(const RadialBaseProblem& problem, const Cylinder& cylinder, const Around& face) {
    axis = cylinder.axis.normalized();
    foot = cylinder.point - axis.dot(cylinder.point) * axis;
    length = foot.norm();
    delta = cylinder.radius - problem.radius;
    K = (length - delta) * (length + delta);
    first = face.start(axis.dot(face.near));
}

double TubeFace::distance(const Ray& ray) const {
    const double B = dot(foot, ray.u) + delta, A = dot(axis, ray.u), R = sqrt(B * B + K * A * A);
    return B < 0 ? (R - B) / (A * A) : K / (B + R);
}

// |p| = r - delta: the flux of p / 3 through the bisector is r (r - delta) / 3. The side of the base sees
// alpha and v clockwise: with r^2 d alpha = d.(y x dy), y across the axis, the boundary integral is that of G
// d alpha, G the antiderivative in v.
Share TubeFace::share(const Ray& ray) const {
    const double B = dot(foot, ray.u) + delta, A = dot(axis, ray.u), R = sqrt(B * B + K * A * A);
    const double t = B < 0 ? (R - B) / (A * A) : K / (B + R);
    // K q^2 - 2 B q - A^2 = 0, q = 1 / t.
    const double dq = (dot(foot, ray.du) / t + A * dot(axis, ray.du)) / R, stretch = t * t * dq;
    Vector p, dp;
    for (int i = 0; i < 3; ++i) {
        p[i] = t * ray.u[i];
        dp[i] = t * ray.du[i] - stretch * ray.u[i];
    }
    const double v = t * A, r = t + delta;
    for (int i = 0; i < 3; ++i) p[i] = p[i] - foot[i] - v * axis[i];
    const double angle = dot(axis, cross(p, dp)) / (r * r);
    const double E2 = length * length + delta * delta + 2 * delta * dot(foot, p) / r;
    const double half = r / (K + v * v);  // 1 / (2 q)
    const double linear = v * (K + v * v / 3) - first * (K + first * first / 3);
    const double volume = half * (half * tube_square(K, first, v) - delta * linear);
    return {volume / 3 * angle, 2 * half * half * tube_area(K, E2, first, v) * angle};
}

Share TubeFace::size(const Ray& ray) const {
    const double B = dot(foot, ray.u) + delta, A = dot(axis, ray.u), R = sqrt(B * B + K * A * A);
    const double t = distance(ray), condition = 1 + (length + std::abs(delta)) / R, r = t + delta;
    const double step = t * norm(ray.du) * (1 + t * (length / t + std::abs(A)) / R);
    // Away from `first` by more, for the rounding of the place.
    const double at = t * A, v = at + std::copysign(noise * t, at - first), half = r / (K + at * at),
                 E = length + std::abs(delta), E2 = E * E;
    const double linear =
        (std::abs(v - first) + noise * std::abs(first)) * (K + std::max(first * first, v * v));
    const double volume = half * (half * tube_square_size(K, first, v) + std::abs(delta) * linear) / 3;
    return {volume * condition * step / r,
            2 * half * half * tube_area_size(K, E2, first, v) * condition * step / r};
}

// ---- Over a cylinder, no root ------------------------------------------------------------------------

TurnedFace::TurnedFace(const RadialBaseProblem& problem, FormId form, const Around& face) : least(infinity) {
    const auto across = [](const Vec3& p) { return Vec3(p.x(), 0, p.z()); };
    const Object& object = problem.objects[form];
    is_round = false;
    slope = first = 0;
    start = face.near.y();
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const double delta = sphere->radius - problem.radius;
        b = across(sphere->center);
        b0 = delta;
        K = (b.norm() - delta) * (b.norm() + delta);
        start = sphere->center.y();
        first = face.start(face.near.y() - start);
        is_round = true;
        if (start >= problem.stretch[0] && start <= problem.stretch[1]) least = 0.5 * (b.norm() - delta);
        return;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&object)) {
        const double delta = cylinder->radius - problem.radius;
        b = across(cylinder->point);
        b0 = delta;
        K = (b.norm() - delta) * (b.norm() + delta);
        return;
    }
    const auto& plane = std::get<Plane>(object);
    Vec3 normal = plane.normal.normalized();
    K = normal.dot(plane.point) - normal.y() * start;
    if (K < 0) {
        normal = -normal;
        K = -K;
    }
    slope = -normal.y();
    b = 0.5 * across(normal);
    b0 = 0;
    if (problem.sites[form].front().is_object()) {
        b0 = 0.5;
        K += problem.radius;
    }
}

double TurnedFace::distance(const Ray& ray) const {
    const double v = ray.y - start, C = K + v * (is_round ? v : slope);
    return C / (2.0 * (b0 + dot(b, ray.u)));
}

Share TurnedFace::share(const Ray& ray) const {
    const double along = dot(b, ray.u), beta = b0 + along, v = ray.y - start;
    const double element = -0.5 * turn(ray) / (beta * beta);
    const double H2 = b0 * b0 + b.squaredNorm() + 2 * b0 * along;  // beta^2 + beta'^2
    if (is_round) return {0.25 * tube_square(K, first, v) * element, tube_area(K, H2, first, v) * element};
    const double sv = slope * v;
    const double volume = v * (K * K + sv * (K + sv / 3));
    const double area = v * (K + 0.5 * sv) * sqrt(H2 + 0.25 * slope * slope);
    return {0.25 * volume * element, area * element};
}

Share TurnedFace::size(const Ray& ray) const {
    const double beta = b0 + dot(b, ray.u), reach = std::abs(b0) + b.norm();
    const double element = 0.5 * norm(ray.du) / (beta * beta) * (1 + reach / beta),
                 rounding = noise * std::abs(ray.y);
    if (is_round) {
        const double at = ray.y - start, v = at + std::copysign(rounding, at - first);
        return {0.25 * tube_square_size(K, first, v) * element,
                tube_area_size(K, reach * reach, first, v) * element};
    }
    const double v = std::abs(ray.y - start) + rounding;
    const double sv = std::abs(slope) * v;
    return {0.25 * v * (K * K + sv * (K + sv)) * element, v * (K + sv) * std::hypot(reach, slope) * element};
}

// ---- Sides of the box over a cylinder ---------------------------------------------------------------

// The face's edges meet but for rounding. As seen from a point near by the gaps between them are next to
// nothing.
FlatFace::FlatFace(const Plane& side, const Vec3& near)
    : normal(side.normal.normalized()), offset(normal.dot(side.point)) {
    point = near + (offset - normal.dot(near)) * normal;
}

// Boundaries run clockwise as seen from the base, counter-clockwise from outside.
Share FlatFace::share(const SpanPoint<double>& p) const {
    const Vec3 q = Vec3(p.x, p.y, p.z) - point;
    const double turn = normal.dot(q.cross(Vec3(p.x1, p.y1, p.z1)));
    const double at_point = offset - normal.y() * point.y(), change = -normal.y() * q.y();
    return {0.5 * (0.5 * at_point + change / 3) * turn, 0.5 * turn};
}

Share FlatFace::size(const SpanPoint<double>& p) const {
    const Vec3 q = Vec3(p.x, p.y, p.z) - point;
    const double turn = (q.norm() + noise * Vec3(p.x, p.y, p.z).norm()) * Vec3(p.x1, p.y1, p.z1).norm();
    return {(std::abs(offset - normal.y() * point.y()) + std::abs(q.y())) * turn, turn};
}

// ---- Skew cylinders over a cylinder -----------------------------------------------------------------

SkewFace::SkewFace(const RadialBaseProblem& problem, const Cylinder& cylinder, double y)
    : axis(cylinder.axis.normalized()),
      point(cylinder.point - axis.dot(cylinder.point) * axis),
      delta(cylinder.radius - problem.radius),
      start(y),
      least(infinity) {
    // The foot of the common perpendicular on the base's axis: C is least there.
    const double square = axis.x() * axis.x() + axis.z() * axis.z(), foot = point.y() / square;
    const double apart = std::abs(axis.x() * point.z() - axis.z() * point.x()) / sqrt(square);
    if (foot >= problem.stretch[0] && foot <= problem.stretch[1] && apart > std::abs(delta))
        least = 0.5 * (apart - delta);
}

// C q^2 - 2 B q - A^2 = 0 in one direction w: A is constant, B = B0 + d_y A y, C quadratic in y. With
// derivatives by the angle.
struct SkewSlice {
    double C0, across, dy, py;  // C = C0 - 2 p_y y + across y^2
    double A, B0, dA, dB0;

    SkewSlice(const SkewFace& f, const Ray& ray)
        : C0((f.point.norm() - f.delta) * (f.point.norm() + f.delta)),
          across(f.axis.x() * f.axis.x() + f.axis.z() * f.axis.z()),
          dy(f.axis.y()),
          py(f.point.y()),
          A(dot(f.axis, ray.u)),
          B0(dot(f.point, ray.u) + f.delta),
          dA(f.axis.x() * ray.u[2] - f.axis.z() * ray.u[0]),
          dB0(f.point.x() * ray.u[2] - f.point.z() * ray.u[0]) {}
};

struct SkewPoint {
    double t, t_y, dS;
};

static SkewPoint skew_point(const SkewSlice& s, double y) {
    const double C = s.C0 + y * (s.across * y - 2 * s.py), half_C_y = s.across * y - s.py;
    const double B = s.B0 + s.dy * s.A * y, R = sqrt(B * B + s.A * s.A * C);
    const double t = B < 0 ? (R - B) / (s.A * s.A) : C / (B + R);
    const double turn = ((s.dB0 + s.dy * s.dA * y) + s.A * s.dA * t) / R;
    const double t_y = (half_C_y - s.dy * s.A * t) / R;
    return {t, t_y, t * sqrt(1 + turn * turn + t_y * t_y)};
}

double SkewFace::distance(const Ray& ray) const { return skew_point(SkewSlice(*this, ray), ray.y).t; }

// How far y may move, in the complex plane, before t or its slope becomes singular: to the zeros of the
// radicand B^2 + A^2 C = A^2 y^2 + 2 h y + k, and to where the surface element vanishes: the square of the
// unit vectors' difference w - w_i, which changes by the surface's own slope over its distance from the
// object's axis.
static double room(const SkewSlice& s, const SkewPoint& p, double delta, double y) {
    const double A2 = s.A * s.A, h = s.B0 * s.dy * s.A - A2 * s.py, k = s.B0 * s.B0 + A2 * s.C0;
    const double discriminant = h * h - A2 * k, value = (A2 * y + 2 * h) * y + k;
    // |value| = A^2 |y - y1| |y - y2|: of conjugate zeros both distances are the same.
    const double derivative = 2 * (std::abs(A2 * y + h) + sqrt(std::abs(discriminant)));
    const double to_zeros = discriminant < 0 ? sqrt(value) / std::abs(s.A) : 2 * value / derivative;
    const double cosine = p.t / p.dS;  // of the angle between w and the normal
    const double to_vertical = cosine * 2 * std::abs(p.t + delta) / sqrt(1 + p.t_y * p.t_y);
    return std::min(to_zeros, to_vertical);
}

template <int n>
static Share skew_rule(const SkewSlice& s, double middle, double half) {
    const quadrature::RuleOf<n>& rule = quadrature::rule<n>();
    Share sum{0, 0};
    for (int i = 0; i < n / 2; ++i)
        for (const double x : {-rule.x[i], rule.x[i]}) {
            const SkewPoint p = skew_point(s, middle + half * x);
            sum.volume += rule.weight[i] * 0.5 * p.t * p.t;
            sum.area += rule.weight[i] * p.dS;
        }
    return {half * sum.volume, half * sum.area};
}

static Share skew_integral(const SkewSlice& s, double delta, double from, double to, int halvings) {
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    const double r = room(s, skew_point(s, middle), delta, middle);
    // On an ellipse within 7 half lengths 8 points do what 16 do within 2.5 (quadrature.hpp).
    if (r >= 7 * std::abs(half)) return skew_rule<8>(s, middle, half);
    if (r >= quadrature::required_reach * std::abs(half) || halvings == 0)
        return skew_rule<quadrature::points>(s, middle, half);
    const Share a = skew_integral(s, delta, from, middle, halvings - 1),
                b = skew_integral(s, delta, middle, to, halvings - 1);
    return {a.volume + b.volume, a.area + b.area};
}

Share SkewFace::share(const Ray& ray) const {
    constexpr int halvings = 40;
    const Share s = skew_integral(SkewSlice(*this, ray), delta, start, ray.y, halvings);
    const double angle = turn(ray);
    return {-s.volume * angle, -s.area * angle};
}

Share SkewFace::size(const Ray& ray) const {
    const SkewSlice s(*this, ray);
    const SkewPoint a = skew_point(s, start), b = skew_point(s, ray.y);
    const double t = std::max(a.t, b.t), dS = std::max(a.dS, b.dS);
    const double height = std::abs(ray.y - start) + noise * std::abs(ray.y);
    return {0.5 * t * t * height * norm(ray.du), dS * height * norm(ray.du)};
}

}  // namespace radial_integrals

// ---- Spans ------------------------------------------------------------------------------------------

RadialFace make_radial_face(const RadialBaseProblem& problem, FormId form,
                            const radial_integrals::Around& face) {
    using namespace radial_integrals;
    const auto* cylinder = std::get_if<Cylinder>(&problem.objects[form]);
    if (problem.is_sphere) {
        if (cylinder != nullptr) return TubeFace(problem, *cylinder, face);
        return RoundFace(problem, form);
    }
    const bool is_skew = cylinder != nullptr && (cylinder->axis.x() != 0 || cylinder->axis.z() != 0);
    if (is_skew) return SkewFace(problem, *cylinder, face.near.y());
    if (problem.sites[form].front().kind == Site::Kind::BoxSide)
        return FlatFace(std::get<Plane>(problem.objects[form]), face.near);
    return TurnedFace(problem, form, face);
}

double least_distance(const RadialFace& face) {
    return std::visit([](const auto& f) { return f.least_distance(); }, face);
}

RadialIntegrals& RadialIntegrals::operator+=(const RadialIntegrals& o) {
    for (int i : {0, 1}) {
        sides[i].volume += o.sides[i].volume;
        sides[i].area += o.sides[i].area;
    }
    length += o.length;
    end_area += o.end_area;
    distance = {std::min(distance[0], o.distance[0]), std::max(distance[1], o.distance[1])};
    gap = {std::max(gap.from_curve, o.gap.from_curve), std::max(gap.apart, o.gap.apart)};
    return *this;
}

namespace {

// (p, t, w), homogeneous.
using ConicPoint = Eigen::Matrix<double, 5, 1>;

// Aimed at for the truncation of one span, as a part of the integrand's size: 1e-12, and the bounds are some
// hundred times the error. What is reported is the bound that is reached.
constexpr double aim = 0x1p-40;

// Nothing that the integrands divide by or take the root of changes by more than this part over a disk.
constexpr double tame_part = 0.75;
constexpr double widest_disk = 16, least_disk = 1.375;  // radii; the span is [-1, 1]

constexpr double square(double x) { return x * x; }

// A quadratic, and a bound of how far it is from its value at 0 for |s| <= r.
struct Quadratic {
    double c0, c1, c2;

    template <class T>
    T operator()(const T& s) const {
        return c0 + s * (c1 + s * c2);
    }
    double deviation(double r) const { return r * (std::abs(c1) + r * std::abs(c2)); }
};

template <int n>
using Nodes = Eigen::Array<double, n, 1>;

// Both halves of a symmetric rule.
template <int n>
struct NodeRule {
    std::array<double, n> s{}, weight{};

    constexpr NodeRule() {
        const quadrature::RuleOf<n>& half = quadrature::rule<n>();
        for (int i = 0; i < n; ++i) {
            s[i] = i < n / 2 ? -half.x[i] : half.x[i - n / 2];
            weight[i] = half.weight[i % (n / 2)];
        }
    }
};
template <int n>
constexpr NodeRule<n> node_rule;

class Conic {
public:
    using RoundFace = radial_integrals::RoundFace;
    using Powers = std::array<ConicPoint, 3>;

    Conic(const ConicPoint& from, const ConicPoint& middle, const ConicPoint& to)
        : Conic(Powers{0.25 * (from + 2 * middle + to), 0.5 * (to - from), 0.25 * (from - 2 * middle + to)}) {
    }

    // On an ellipse whose semi-axes' sum is rho, in the disk |s| <= r with 2 r = rho + 1 / rho, the n-point
    // rule errs by (64/15) rho^(-2n) / (1 - rho^-2) of the integrand's bound (quadrature.hpp).
    void add(const RoundFace& left, const RoundFace& right, RadialIntegrals& sum) const {
        int budget = quadrature::most_halvings;
        add(left, right, sum, 40, budget);
    }

private:
    static constexpr int most_points = 20;

    void add(const RoundFace& left, const RoundFace& right, RadialIntegrals& sum, int halvings,
             int& budget) const {
        const double middle_t = t_.c0 / w_.c0;
        // w (t - middle_t).
        const Quadratic turned{0, t_.c1 - middle_t * w_.c1, t_.c2 - middle_t * w_.c2};
        const double r = disk(turned, middle_t - std::max({0.0, -left.delta, -right.delta}));
        // NaN where there is no disk.
        if (!(r > 1) && halvings > 0 && budget > 0) return add_halves(left, right, sum, halvings, budget);
        const double rho = r + sqrt(r * r - 1), shrink = 1 / square(rho);
        const double least_w = w_.c0 - w_.deviation(r);
        // Bound of |p x dp| w^2 on a disk.
        const double m0 = x_[0].norm(), m1 = x_[1].norm(), m2 = x_[2].norm(), moment_of_span = m0 + m1 + m2;
        const double moment = (m0 + r * (m1 + r * m2)) / square(least_w);
        const double needed = aim * moment_of_span / square(std::max(w_.c0, 1.0));
        double truncated = 64.0 / 15 / (1 - shrink) * square(square(shrink));  // of an integrand's bound
        int points = 4;
        for (; points < most_points && !(truncated * moment <= needed); points += 2)
            truncated *= square(shrink);
        if (!(truncated * moment <= needed) && halvings > 0 && budget > 0)
            return add_halves(left, right, sum, halvings, budget);
        const double moment_here = moment_of_span / square(std::min(w_(-1.0), w_(1.0)));
        const double rounding = 2 * term_rounding * moment_here;
        // Where halving ended without a disk, the whole part.
        const bool is_tame = truncated < infinity;
        const double reach = is_tame ? r : 1,
                     near_w = is_tame ? least_w : std::min({w_(-1.0), w_(0.0), w_(1.0)});
        const double turned_t = turned.deviation(reach) / near_w,
                     speed = sqrt(speed2_[0] + speed2_deviation(reach)) / square(near_w);
        sum.length.error += (is_tame ? truncated : 4) * speed;
        const double error = (is_tame ? truncated * moment : 4 * moment_here) + rounding;
        for (const int side : {0, 1}) {
            const auto bounds =
                factor_bounds(side == 0 ? left : right, middle_t - turned_t, middle_t + turned_t);
            sum.sides[side].volume.error += error * bounds.volume;
            sum.sides[side].area.error += error * bounds.area;
        }
        switch (points) {
            case 4: return add_values<4>(left, right, sum);
            case 6: return add_values<6>(left, right, sum);
            case 8: return add_values<8>(left, right, sum);
            case 10: return add_values<10>(left, right, sum);
            case 12: return add_values<12>(left, right, sum);
            case 14: return add_values<14>(left, right, sum);
            case 16: return add_values<16>(left, right, sum);
            case 18: return add_values<18>(left, right, sum);
            default: return add_values<most_points>(left, right, sum);
        }
    }

    void add_halves(const RoundFace& left, const RoundFace& right, RadialIntegrals& sum, int halvings,
                    int& budget) const {
        --budget;
        for (const double sign : {-1.0, 1.0})
            Conic(Powers{a_[0] + sign * 0.5 * a_[1] + 0.25 * a_[2], 0.5 * a_[1] + sign * 0.5 * a_[2],
                         0.25 * a_[2]})
                .add(left, right, sum, halvings - 1, budget);
    }

    explicit Conic(const Powers& a) : a_(a), t_{a[0][3], a[1][3], a[2][3]}, w_{a[0][4], a[1][4], a[2][4]} {
        // p x dp and dp, both times w^2: the powers that would be higher cancel.
        const Vec3 p0 = a[0].head<3>(), p1 = a[1].head<3>(), p2 = a[2].head<3>();
        x_ = {p0.cross(p1), 2 * p0.cross(p2), p1.cross(p2)};
        const Vec3 y0 = p1 * w_.c0 - p0 * w_.c1, y1 = 2 * (p2 * w_.c0 - p0 * w_.c2),
                   y2 = p2 * w_.c1 - p1 * w_.c2;
        speed2_ = {y0.dot(y0), 2 * y0.dot(y1), y1.dot(y1) + 2 * y0.dot(y2), 2 * y1.dot(y2), y2.dot(y2)};
    }

    // The radius of a disk on which the integrands are analytic; NaN if there is none that helps. On it t
    // keeps to its side of an edge, and |dp|^2 w^4 keeps from zero: it is near its value at 0, or a multiple
    // of w^2, which it is on a circle. `turned` is w times the change of t from its value at 0, which is
    // `to_edge` beyond the edge.
    double disk(const Quadratic& turned, double to_edge) const {
        const auto reach = [](double linear, double quadratic, double bound) {
            return 2 * bound / (linear + sqrt(square(linear) + 4 * quadratic * bound));
        };
        const double w1 = std::abs(w_.c1), w2 = std::abs(w_.c2), part = tame_part;
        const double room = part * to_edge;
        double r =
            std::min({widest_disk, reach(w1, w2, part * w_.c0),
                      reach(std::abs(turned.c1) + room * w1, std::abs(turned.c2) + room * w2, room * w_.c0)});
        const double mean = speed2_[0] / square(w_.c0);
        const double rest1 = std::abs(speed2_[1] - 2 * mean * w_.c0 * w_.c1),
                     rest2 = std::abs(speed2_[2] - mean * (w_.c1 * w_.c1 + 2 * w_.c0 * w_.c2)),
                     rest3 = std::abs(speed2_[3] - 2 * mean * w_.c1 * w_.c2),
                     rest4 = std::abs(speed2_[4] - mean * w_.c2 * w_.c2);
        for (; r >= least_disk; r *= 0.875) {
            if (speed2_deviation(r) <= part * speed2_[0]) return r;
            const double least_w = w_.c0 - w_.deviation(r);
            if (r * (rest1 + r * (rest2 + r * (rest3 + r * rest4))) <= part * mean * square(least_w))
                return r;
        }
        return std::numeric_limits<double>::quiet_NaN();
    }

    // How far |dp|^2 w^4 is from its value at 0 for |s| <= r.
    double speed2_deviation(double r) const {
        const auto& v = speed2_;
        return r * (std::abs(v[1]) + r * (std::abs(v[2]) + r * (std::abs(v[3]) + r * std::abs(v[4]))));
    }

    template <int n>
    void add_values(const RoundFace& left, const RoundFace& right, RadialIntegrals& sum) const {
        const Nodes<n> s = Eigen::Map<const Nodes<n>>(node_rule<n>.s.data());
        const Eigen::Map<const Nodes<n>> rule_weight(node_rule<n>.weight.data());
        const Nodes<n> reciprocal = 1 / w_(s), t = t_(s) * reciprocal;
        const Nodes<n> weight = rule_weight * reciprocal.square();
        const auto& v = speed2_;
        const double length = (weight * sqrt(v[0] + s * (v[1] + s * (v[2] + s * (v[3] + s * v[4]))))).sum();
        sum.length += {length, term_rounding * length};
        for (const int side : {0, 1}) {
            const RoundFace& face = side == 0 ? left : right;
            const Quadratic along{face.axis.dot(x_[0]), face.axis.dot(x_[1]), face.axis.dot(x_[2])};
            const Nodes<n> element = weight * along(s);
            const RoundFace::Factors<Nodes<n>> f = face.factors(t);
            sum.sides[side].volume.value += (element * f.volume).sum();
            sum.sides[side].area.value += (element * f.area).sum();
        }
    }

    Powers a_;
    Quadratic t_, w_;
    std::array<Vec3, 3> x_;
    std::array<double, 5> speed2_;
};

// t^2 / 2 at a point of a span, and its derivative.
std::array<double, 2> half_square(const SpanPoint<double>& p, bool is_sphere) {
    const double y = is_sphere ? p.y : 0.0;
    return {0.5 * (p.x * p.x + y * y + p.z * p.z), p.x * p.x1 + y * p.y1 + p.z * p.z1};
}

// At most as many extremes as that has t along a span, inside: t^2 = p.p / w^2, of which the derivative is a
// positive factor times p.(p' w - p w'). In the Bernstein basis a polynomial has no more zeros in [0, 1] than
// its coefficients have changes of sign [Farin02, sec. 5.3, Descartes].
int most_extremes(const PowerSpan& span, bool is_sphere) {
    constexpr int most = PowerSpan::largest_degree;
    const int d = span.degree();
    const auto points = span.control_points();
    // Times binomials, so that products are convolutions.
    std::array<Vector4d, most + 1> p;
    std::array<Vector4d, most> slope;
    double binomial = 1;
    for (int k = 0; k <= d; ++k) {
        p[k] = binomial * points[k];
        if (!is_sphere) p[k].y() = 0;
        binomial *= static_cast<double>(d - k) / (k + 1);
    }
    for (int k = 0; k < d; ++k) slope[k] = (k + 1) * p[k + 1] - (d - k) * p[k];
    std::array<Vec3, 2 * most> turn;
    turn.fill(Vec3::Zero());
    for (int i = 0; i <= d; ++i)
        for (int k = 0; k < d; ++k)
            turn[i + k] += p[i].w() * slope[k].head<3>() - slope[k].w() * p[i].head<3>();
    std::array<double, 3 * most> sum{};
    double size = 0, steepest = 0;
    for (int i = 0; i <= d; ++i) {
        size = std::max(size, p[i].squaredNorm());
        for (int k = 0; k < 2 * d; ++k) sum[i + k] += p[i].head<3>().dot(turn[k]);
    }
    for (int k = 0; k < d; ++k) steepest = std::max(steepest, slope[k].norm());
    // Coefficients below that are what rounding leaves, by which t hardly turns.
    const double rounding = 16 * std::numeric_limits<double>::epsilon() * size * steepest;
    int changes = 0;
    double last = 0;
    for (int k = 0; k < 3 * d; ++k) {
        if (std::abs(sum[k]) <= rounding) continue;
        changes += sum[k] * last < 0;
        last = sum[k];
    }
    return changes;
}

// The range of t along a span that has one extreme inside at most.
void extend_by_extreme(Range& range, const PowerSpan& span, bool is_sphere) {
    const auto at = [&](double s) { return half_square(span.at(s), is_sphere); };
    const auto extend_by = [&](double square) {
        range = {std::min(range[0], sqrt(2 * square)), std::max(range[1], sqrt(2 * square))};
    };
    double low = -1, high = 1;
    std::array<double, 2> first = at(low), last = at(high);
    extend_by(first[0]);
    extend_by(last[0]);
    if ((first[1] > 0) == (last[1] > 0)) return;
    // Regula falsi, the end that stays weighted down ("Illinois"). Near an extreme half of the digits of s
    // are enough.
    constexpr int most_steps = 30;
    constexpr double enough = 0x1p-30;
    int moved_end = 0;  // the last one: -1 low, 1 high
    for (int i = 0; i < most_steps; ++i) {
        const double s = high - last[1] * (high - low) / (last[1] - first[1]);
        const std::array<double, 2> next = at(s);
        const bool is_first = (next[1] > 0) == (first[1] > 0);
        const double moved = is_first ? s - low : high - s;
        if (is_first) {
            low = s;
            first = next;
            if (moved_end == -1) last[1] *= 0.5;
            moved_end = -1;
        } else {
            high = s;
            last = next;
            if (moved_end == 1) first[1] *= 0.5;
            moved_end = 1;
        }
        if (next[1] == 0 || std::min(moved, high - low) <= enough) break;
    }
    extend_by(first[0]);
    extend_by(last[0]);
}

// The range of t along a span.
void extend_by_extremes(Range& range, const PowerSpan& span, bool is_sphere, int halvings = 12) {
    if (halvings == 0 || most_extremes(span, is_sphere) <= 1)
        return extend_by_extreme(range, span, is_sphere);
    for (const int side : {0, 1}) extend_by_extremes(range, span.half(side), is_sphere, halvings - 1);
}

// What a face takes of a point of its boundary.
template <class Face>
const Ray& place_for(const Face&, const SpanPoint<double>&, const Ray& ray) {
    return ray;
}
const SpanPoint<double>& place_for(const radial_integrals::FlatFace&, const SpanPoint<double>& p,
                                   const Ray&) {
    return p;
}

// How far a point of the boundary is from the face's surface, along its ray if that tells anything.
template <class Face>
double gap_to(const Face& f, const SpanPoint<double>&, const Ray& ray, double t) {
    return f.distance(ray) - t;
}
double gap_to(const radial_integrals::FlatFace& f, const SpanPoint<double>& p, const Ray&, double) {
    return f.offset - f.normal.dot(Vec3(p.x, p.y, p.z));
}

// Where splines err most (space_spline.cpp): between the nodes of their interpolation.
void extend_by_gaps(RadialGap& most, const PowerSpan& span, bool is_sphere, const RadialFace& left,
                    const RadialFace* right) {
    for (const double s : {-0.5, 0.0, 0.5}) {
        const SpanPoint<double> p = span.at(s);
        const Ray ray = ray_to(p, is_sphere);
        const double t = sqrt(2 * half_square(p, is_sphere)[0]);
        const auto off = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return gap_to(f, p, ray, t); }, face);
        };
        const double l = off(left), r = right != nullptr ? off(*right) : 0;
        most.from_curve = std::max({most.from_curve, std::abs(l), std::abs(r)});
        most.apart = std::max(most.apart, std::abs(l - r));
    }
}

struct SpanIntegrand {
    bool is_sphere;
    const RadialFace& left;
    const RadialFace* right;

    std::array<double, 6> operator()(const SpanPoint<double>& p, std::array<double, 6>* sizes) const {
        const Ray ray = ray_to(p, is_sphere);
        const auto share = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return f.share(place_for(f, p, ray)); }, face);
        };
        const Share l = share(left), r = right != nullptr ? share(*right) : Share{0, 0};
        const double speed = sqrt(p.x1 * p.x1 + p.y1 * p.y1 + p.z1 * p.z1);
        const double end = right == nullptr ? 0.5 * (p.x * p.x + p.z * p.z) : 0;
        if (sizes != nullptr) set_sizes(p, ray, speed, end * norm(ray.du), *sizes);
        return {l.volume, l.area, r.volume, r.area, speed, end * turn(ray)};
    }

private:
    void set_sizes(const SpanPoint<double>& p, const Ray& ray, double speed, double end,
                   std::array<double, 6>& sizes) const {
        const auto size = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return f.size(place_for(f, p, ray)); }, face);
        };
        const Share l = size(left), r = right != nullptr ? size(*right) : Share{0, 0};
        sizes = {l.volume, l.area, r.volume, r.area, speed, end};
    }
};

}  // namespace

void add_conic(const std::array<Vector4d, 3>& points, const RadialFace& left, const RadialFace& right,
               RadialIntegrals& sum) {
    // The curve is on the cone |p| = t, and its tangent from an end touches the cone there.
    std::array<ConicPoint, 3> p;
    for (int i : {0, 1, 2}) p[i] << points[i].head<3>(), points[i].head<3>().norm(), points[i].w();
    const int end = p[0][3] > p[2][3] ? 0 : 2;
    p[1][3] = p[end].head<3>().dot(p[1].head<3>()) / p[end][3];
    Conic(p[0], p[1], p[2])
        .add(std::get<radial_integrals::RoundFace>(left), std::get<radial_integrals::RoundFace>(right), sum);
    // Weights 1, w, 1.
    const double scale = sqrt(p[0][4] * p[2][4]);
    const auto distance = [&](int i) { return p[i][3] / p[i][4]; };
    extend(sum.distance, distance(0), distance(1), distance(2), p[1][4] / scale);
}

void add_segment(const Vec3& from, const Vec3& to, const RadialFace& left, const RadialFace& right,
                 RadialIntegrals& sum) {
    // Ends may be next to each other as seen from the centre: what is left of from x to is that of their
    // difference.
    const Vec3 along = to - from, moment = from.cross(along);
    const double length = along.norm(), size = term_rounding * from.norm() * length;
    sum.length += {length, term_rounding * length};
    for (const int side : {0, 1}) {
        const auto& face = std::get<radial_integrals::RoundFace>(side == 0 ? left : right);
        const auto f = face.factors(face.d1);
        const double turned = face.axis.dot(moment);
        sum.sides[side].volume += {f.volume * turned, f.volume * size};
        sum.sides[side].area += {f.area * turned, f.area * size};
    }
    sum.distance = {std::min({sum.distance[0], from.norm(), to.norm()}),
                    std::max({sum.distance[1], from.norm(), to.norm()})};
}

void add_span(std::span<const Vector4d> points, bool is_conic, bool is_sphere, const RadialFace& left,
              const RadialFace* right, RadialIntegrals& sum) {
    const PowerSpan span(points);
    std::array<Integral, 6> parts{};
    // A spline is off its arc by more than the integrals of its spans could be.
    integrate_estimated(span, SpanIntegrand{is_sphere, left, right}, is_conic ? 1e-9 : 1e-7, parts);
    sum.sides[0].volume += parts[0];
    sum.sides[0].area += parts[1];
    sum.sides[1].volume += parts[2];
    sum.sides[1].area += parts[3];
    if (points.size() == 2) {
        const double length = (points[1] - points[0]).head<3>().norm();
        parts[4] = {length, term_rounding * length};
    } else if (is_conic) {
        parts[4] = span_integrals::length(span);
    }
    sum.length += parts[4];
    sum.end_area += parts[5];
    extend_by_extremes(sum.distance, span, is_sphere);
    extend_by_gaps(sum.gap, span, is_sphere, left, right);
}

}  // namespace vcell
