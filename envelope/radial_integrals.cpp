#include "radial_integrals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "joined_spans.hpp"

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
    const double s = sqrt(E2 + v * v), far = std::abs(v);
    return (0.5 * K + 0.125 * E2) * (far * s + E2 * std::asinh(far / sqrt(E2))) + 0.25 * far * s * s * s;
}

// The integral of (K + x^2)^2 over 0 <= x <= v.
double tube_square(double K, double v) {
    const double v2 = v * v;
    return v * (K * K + v2 * (2 * K / 3 + 0.2 * v2));
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
        d1 = 0.5 * (c - delta);
        d2 = 0.5 * (c + delta);
        shape = delta == 0 ? Shape::Flat : Shape::Hyperboloid;
        k = 2 * d1 * d2;
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
    d2 = d1;
    c = 2 * d1;
}

double RoundFace::distance(const Ray& ray) const { return k / (e0 + e1 * dot(axis, ray.u)); }

double RoundFace::volume_factor(double t) const {
    switch (shape) {
        case Shape::Flat:
            return d1 / 6;
        case Shape::Paraboloid:
            return (t + d1) / 12;
        case Shape::Hyperboloid:
            break;
    }
    return c / 12 * (t + d1) / (t + d2);
}

// The form f(t) b.(p x dp) has the derivative f' dt ^ b.(p x dp) + f b.(dp x dp), of size t |f'| + 2 f at
// most. Of a hyperboloid, c (t + d1) / (12 (t + d2)) has t |f'| < c |delta| / (12 (t + d2)), and t > 0.
double RoundFace::volume_slope(double far) const {
    switch (shape) {
        case Shape::Flat:
            return d1 / 3;
        case Shape::Paraboloid:
            return (3 * far + 2 * d1) / 12;
        case Shape::Hyperboloid:
            break;
    }
    return c / 12 * (2 * std::max(1.0, d1 / d2) + std::abs(delta) / d2);
}

// The mean of sqrt(x (x + delta)) over d1 <= x <= t. With S = sqrt(x) + sqrt(x + delta), 4 x + 2 delta = S^2
// + delta^2 / S^2, and the antiderivative is (S^4 - delta^4 / S^4) / 32 - delta^2 log(S) / 4; its differences
// are divided by t - d1 here. They cancel where one distance is far below |delta|; then the integral over the
// root of that distance is all but a polynomial.
static double mean_root(double d1, double d2, double delta, double t) {
    const double near0 = std::min(d1, d2), near1 = std::min(t, t + delta), apart = std::abs(delta);
    if (4 * std::max(near0, near1) < apart) {
        // x^2 the smaller distance: 2 x^2 sqrt(x^2 + apart) dx, whose singularities are at least 2 intervals
        // away.
        const double x0 = sqrt(near0), x1 = sqrt(near1), middle = 0.5 * (x0 + x1), half = 0.5 * (x1 - x0);
        const auto& rule = quadrature::rule<10>();
        double sum = 0;
        for (int i = 0; i < 5; ++i)
            for (const double x : {middle - half * rule.x[i], middle + half * rule.x[i]})
                sum += rule.weight[i] * x * x * sqrt(x * x + apart);
        return sum / (x0 + x1);
    }
    const double a0 = sqrt(d1), a1 = sqrt(t), b0 = sqrt(d2), b1 = sqrt(t + delta);
    const double S0 = a0 + b0, S1 = a1 + b1, sum = S0 + S1;
    const double reciprocal = 1 / ((a0 + a1) * (b0 + b1));  // (S1 - S0) / ((t - d1) (S1 + S0))
    const double z = (t - d1) * reciprocal, z2 = z * z;     // log(S1 / S0) = 2 atanh(z)
    double log_part = 0;                                    // atanh(z) / z
    if (z2 < 0.04) {
        const double z4 = z2 * z2, z8 = z4 * z4;
        const auto pair = [&](int odd) { return 1.0 / odd + z2 * (1.0 / (odd + 2)); };
        log_part = pair(1) + z4 * pair(5) + z8 * (pair(9) + z4 * pair(13) + z8 * (pair(17) + z4 * pair(21)));
    } else {
        log_part = std::atanh(z) / z;
    }
    const double square = delta * delta, product = S0 * S1, quotient = square / (product * product);
    return reciprocal *
           (sum * sum * (S0 * S0 + S1 * S1) * (1 + quotient * quotient) / 32 - 0.5 * square * log_part);
}

double RoundFace::area_factor(double t) const {
    switch (shape) {
        case Shape::Flat:
            return 0.5;
        case Shape::Paraboloid: {
            const double x = sqrt(t / d1);  // the mean of sqrt(x / d1) / 2
            return (x * x + x + 1) / (3 * (x + 1));
        }
        case Shape::Hyperboloid:
            break;
    }
    return c * mean_root(d1, d2, delta, t) / (2 * sqrt(d1 * d2) * (t + d2));
}

// Both factors, or their bounds where t stays off the cut.
static Share factors(const RoundFace& f, double t) { return {f.volume_factor(t), f.area_factor(t)}; }

static Share factor_bounds(const RoundFace& f, double least, double most) {
    using Shape = RoundFace::Shape;
    if (f.shape == Shape::Flat) return {f.d1 / 6, 0.5};
    most = std::max(most, f.d1);
    if (!(least > std::max(0.0, -f.delta))) return {infinity, infinity};
    if (f.shape == Shape::Paraboloid) return {(most + f.d1) / 12, 0.5 * sqrt(most / f.d1)};
    return {f.c / 12 * (most + f.d1) / (least + f.d2),
            f.c * sqrt(most * (most + std::abs(f.delta))) / (2 * sqrt(f.d1 * f.d2) * (least + f.d2))};
}

Share RoundFace::share(const Ray& ray) const {
    const double t = distance(ray), element = t * t * dot(axis, cross(ray.u, ray.du));
    const Share f = factors(*this, t);
    return {f.volume * element, f.area * element};
}

Share RoundFace::size(const Ray& ray) const {
    const double t = distance(ray), condition = 1 + (std::abs(e0) + e1) * t / k;
    const double element = t * t * norm(ray.du) * condition;
    return {volume_factor(t) * element, area_factor(t) * element};
}

// ---- Cylinders over a sphere ------------------------------------------------------------------------

TubeFace::TubeFace(const RadialBaseProblem& problem, const Cylinder& cylinder) {
    axis = cylinder.axis.normalized();
    foot = cylinder.point - axis.dot(cylinder.point) * axis;
    length = foot.norm();
    delta = cylinder.radius - problem.radius;
    K = (length - delta) * (length + delta);
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
    const double volume = half * (half * tube_square(K, v) - delta * v * (K + v * v / 3));
    return {volume / 3 * angle, 2 * half * half * tube_area(K, E2, v) * angle};
}

Share TubeFace::size(const Ray& ray) const {
    const double B = dot(foot, ray.u) + delta, A = dot(axis, ray.u), R = sqrt(B * B + K * A * A);
    const double t = distance(ray), condition = 1 + (length + std::abs(delta)) / R, r = t + delta;
    const double step = t * norm(ray.du) * (1 + t * (length / t + std::abs(A)) / R);
    const double v = std::abs(t * A) + noise * t, half = r / (K + v * v), E = length + std::abs(delta),
                 E2 = E * E;
    const double volume = half * (half * tube_square(K, v) + std::abs(delta) * v * (K + v * v / 3)) / 3;
    return {volume * condition * step / r, 2 * half * half * tube_area_size(K, E2, v) * condition * step / r};
}

// ---- Over a cylinder, no root ------------------------------------------------------------------------

TurnedFace::TurnedFace(const RadialBaseProblem& problem, FormId form, double y) : least(infinity) {
    const auto across = [](const Vec3& p) { return Vec3(p.x(), 0, p.z()); };
    const Object& object = problem.objects[form];
    is_round = false;
    slope = start = 0;
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const double delta = sphere->radius - problem.radius;
        b = across(sphere->center);
        b0 = delta;
        K = (b.norm() - delta) * (b.norm() + delta);
        start = sphere->center.y();
        is_round = true;
        if (start >= problem.stretch[0] && start <= problem.stretch[1]) least = 0.5 * (b.norm() - delta);
        return;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&object)) {
        const double delta = cylinder->radius - problem.radius;
        b = across(cylinder->point);
        b0 = delta;
        K = (b.norm() - delta) * (b.norm() + delta);
        start = y;
        return;
    }
    const auto& plane = std::get<Plane>(object);
    Vec3 normal = plane.normal.normalized();
    start = y;
    K = normal.dot(plane.point) - normal.y() * y;
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
    if (is_round) return {0.25 * tube_square(K, v) * element, tube_area(K, H2, v) * element};
    const double sv = slope * v;
    const double volume = v * (K * K + sv * (K + sv / 3));
    const double area = v * (K + 0.5 * sv) * sqrt(H2 + 0.25 * slope * slope);
    return {0.25 * volume * element, area * element};
}

Share TurnedFace::size(const Ray& ray) const {
    const double beta = b0 + dot(b, ray.u), reach = std::abs(b0) + b.norm();
    const double v = std::abs(ray.y - start) + noise * std::abs(ray.y);
    const double element = 0.5 * norm(ray.du) / (beta * beta) * (1 + reach / beta);
    if (is_round) return {0.25 * tube_square(K, v) * element, tube_area_size(K, reach * reach, v) * element};
    const double sv = std::abs(slope) * v;
    return {0.25 * v * (K * K + sv * (K + sv)) * element, v * (K + sv) * std::hypot(reach, slope) * element};
}

// ---- Sides of the box over a cylinder ---------------------------------------------------------------

FlatFace::FlatFace(const Plane& side, double y)
    : normal(side.normal.normalized()), offset(normal.dot(side.point)) {
    point = Vec3(0, y, 0) + (offset - normal.y() * y) * normal;
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
    const double turn = (q.norm() + std::abs(p.y)) * Vec3(p.x1, p.y1, p.z1).norm();
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

RadialFace make_radial_face(const RadialBaseProblem& problem, FormId form, double y) {
    using namespace radial_integrals;
    const auto* cylinder = std::get_if<Cylinder>(&problem.objects[form]);
    if (problem.is_sphere) {
        if (cylinder != nullptr) return TubeFace(problem, *cylinder);
        return RoundFace(problem, form);
    }
    const bool is_skew = cylinder != nullptr && (cylinder->axis.x() != 0 || cylinder->axis.z() != 0);
    if (is_skew) return SkewFace(problem, *cylinder, y);
    if (problem.sites[form].front().kind == Site::Kind::BoxSide)
        return FlatFace(std::get<Plane>(problem.objects[form]), y);
    return TurnedFace(problem, form, y);
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
    return *this;
}

namespace {

// (p, t, w), homogeneous.
using ConicPoint = Eigen::Matrix<double, 5, 1>;

// A Gauss-Legendre rule with the radius of a disk around [-1, 1] that contains an ellipse on which an
// integrand of size 1 leaves an error of `truncation` < 2e-15: less than rounding.
struct RuleChoice {
    double reach, truncation;
    int half_points;
    const double *x, *weight;
};

template <int n>
RuleChoice choice(double reach) {
    const double rho = reach + sqrt(reach * reach - 1), square = rho * rho;
    const quadrature::RuleOf<n>& rule = quadrature::rule<n>();
    return {reach, 64.0 / 15 * std::pow(square, -n) / (1 - 1 / square), n / 2, rule.x.data(),
            rule.weight.data()};
}

const std::array<RuleChoice, 5>& rule_choices() {
    static const std::array choices{choice<6>(10), choice<8>(5), choice<10>(3.3), choice<12>(2.5),
                                    choice<16>(1.8)};
    return choices;
}

// A quadratic, and a bound of how far it is from its value at 0 for |s| <= r.
struct Quadratic {
    double c0, c1, c2;

    double operator()(double s) const { return c0 + s * (c1 + s * c2); }
    double deviation(double r) const { return r * (std::abs(c1) + r * std::abs(c2)); }
};

class Conic {
public:
    using Powers = std::array<ConicPoint, 3>;

    Conic(const ConicPoint& from, const ConicPoint& middle, const ConicPoint& to)
        : Conic(Powers{0.25 * (from + 2 * middle + to), 0.5 * (to - from), 0.25 * (from - 2 * middle + to)}) {
    }

    void add(const radial_integrals::RoundFace& left, const radial_integrals::RoundFace& right,
             RadialIntegrals& sum, int halvings = 40) const {
        const double edge_of_t = std::max({0.0, -left.delta, -right.delta});
        const RuleChoice* rule = nullptr;
        for (const RuleChoice& c : rule_choices()) {
            if (!is_tame(c.reach, edge_of_t)) continue;
            rule = &c;
            break;
        }
        if (rule == nullptr && halvings > 0) {
            for (const double sign : {-1.0, 1.0})
                Conic(Powers{a_[0] + sign * 0.5 * a_[1] + 0.25 * a_[2], 0.5 * a_[1] + sign * 0.5 * a_[2],
                             0.25 * a_[2]})
                    .add(left, right, sum, halvings - 1);
            return;
        }
        if (rule == nullptr) rule = &rule_choices().back();

        const int count = 2 * rule->half_points;
        std::array<double, 16> s, t, weight;
        double length = 0;
        for (int i = 0; i < count; ++i) {
            s[i] = i < rule->half_points ? -rule->x[i] : rule->x[i - rule->half_points];
            const double reciprocal = 1 / w_(s[i]);
            t[i] = t_(s[i]) * reciprocal;
            weight[i] = rule->weight[i % rule->half_points] * reciprocal * reciprocal;
            length +=
                weight[i] *
                sqrt(speed2_[0] +
                     s[i] * (speed2_[1] + s[i] * (speed2_[2] + s[i] * (speed2_[3] + s[i] * speed2_[4]))));
        }
        sum.length += {length, term_rounding * length};

        const double w = w_.c0 - w_.deviation(rule->reach), middle_t = t_.c0 / w_.c0;
        const double turned_t =
            Quadratic{0, t_.c1 - middle_t * w_.c1, t_.c2 - middle_t * w_.c2}.deviation(rule->reach) / w;
        const double moment =
            (x_[0].norm() + rule->reach * (x_[1].norm() + rule->reach * x_[2].norm())) / (w * w);
        const double error = 2 * rule->truncation * moment;
        const double size = 2 * term_rounding * (x_[0].norm() + x_[1].norm() + x_[2].norm()) /
                            std::min(square(w_(-1)), square(w_(1)));
        const double far = std::max(t_(-1) / w_(-1), t_(1) / w_(1));
        for (const int side : {0, 1}) {
            const radial_integrals::RoundFace& face = side == 0 ? left : right;
            const Quadratic n{face.axis.dot(x_[0]), face.axis.dot(x_[1]), face.axis.dot(x_[2])};
            double volume = 0, area = 0;
            for (int i = 0; i < count; ++i) {
                const double element = weight[i] * n(s[i]);
                volume += element * face.volume_factor(t[i]);
                area += element * face.area_factor(t[i]);
            }
            const auto bounds = factor_bounds(face, middle_t - turned_t, middle_t + turned_t);
            const auto sizes = factors(face, far);
            sum.sides[side].volume += {volume, error * bounds.volume + size * sizes.volume};
            sum.sides[side].area += {area, error * bounds.area + size * sizes.area};
        }
    }

private:
    explicit Conic(const Powers& a) : a_(a), t_{a[0][3], a[1][3], a[2][3]}, w_{a[0][4], a[1][4], a[2][4]} {
        // p x dp and dp, both times w^2: the powers that would be higher cancel.
        const Vec3 p0 = a[0].head<3>(), p1 = a[1].head<3>(), p2 = a[2].head<3>();
        x_ = {p0.cross(p1), 2 * p0.cross(p2), p1.cross(p2)};
        const Vec3 y0 = p1 * w_.c0 - p0 * w_.c1, y1 = 2 * (p2 * w_.c0 - p0 * w_.c2),
                   y2 = p2 * w_.c1 - p1 * w_.c2;
        speed2_ = {y0.dot(y0), 2 * y0.dot(y1), y1.dot(y1) + 2 * y0.dot(y2), 2 * y1.dot(y2), y2.dot(y2)};
    }

    static double square(double x) { return x * x; }

    // Nothing that the integrands divide by or take the root of changes by more than this part over the disk.
    bool is_tame(double reach, double edge_of_t) const {
        constexpr double part = 0.875;
        const double change = w_.deviation(reach), middle_t = t_.c0 / w_.c0;
        if (!(change <= part * w_.c0)) return false;
        const Quadratic turned{0, t_.c1 - middle_t * w_.c1, t_.c2 - middle_t * w_.c2};
        if (!(turned.deviation(reach) <= part * (w_.c0 - change) * (middle_t - edge_of_t))) return false;
        double power = reach, speed_change = 0;
        for (int i = 1; i < 5; ++i, power *= reach) speed_change += power * std::abs(speed2_[i]);
        return speed_change <= part * speed2_[0];
    }

    Powers a_;
    Quadratic t_, w_;
    std::array<Vec3, 3> x_;
    std::array<double, 5> speed2_;
};

// The range of t along a span whose ends have slopes of different signs contains what is between them.
template <class Distance, class Slope>
void extend_by_extreme(Range& range, const Distance& distance, const Slope& slope) {
    range = {std::min({range[0], distance(-1.0), distance(1.0)}),
             std::max({range[1], distance(-1.0), distance(1.0)})};
    double low = -1, high = 1;
    const bool rises = slope(low) > 0;
    if (rises == (slope(high) > 0)) return;
    // Near an extreme half of the digits of s are enough.
    constexpr int halvings = 30;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (rises == (slope(middle) > 0) ? low : high) = middle;
    }
    range = {std::min(range[0], distance(low)), std::max(range[1], distance(low))};
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

struct SpanIntegrand {
    bool is_sphere;
    const RadialFace& left;
    const RadialFace* right;

    std::array<double, 6> operator()(const SpanPoint<double>& p) const {
        const Ray ray = ray_to(p, is_sphere);
        const auto share = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return f.share(place_for(f, p, ray)); }, face);
        };
        const Share l = share(left), r = right != nullptr ? share(*right) : Share{0, 0};
        const double end = right == nullptr ? 0.5 * (p.x * p.x + p.z * p.z) * turn(ray) : 0;
        return {l.volume, l.area, r.volume, r.area, sqrt(p.x1 * p.x1 + p.y1 * p.y1 + p.z1 * p.z1), end};
    }
    std::array<double, 6> sizes(const SpanPoint<double>& p) const {
        const Ray ray = ray_to(p, is_sphere);
        const auto size = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return f.size(place_for(f, p, ray)); }, face);
        };
        const Share l = size(left), r = right != nullptr ? size(*right) : Share{0, 0};
        const double speed = sqrt(p.x1 * p.x1 + p.y1 * p.y1 + p.z1 * p.z1);
        const double end = right == nullptr ? 0.5 * (p.x * p.x + p.z * p.z) * norm(ray.du) : 0;
        return {l.volume, l.area, r.volume, r.area, speed, end};
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
    const Vec3 moment = from.cross(to);
    const double length = (to - from).norm(), size = term_rounding * moment.norm();
    sum.length += {length, term_rounding * length};
    for (const int side : {0, 1}) {
        const auto& face = std::get<radial_integrals::RoundFace>(side == 0 ? left : right);
        const auto f = factors(face, face.d1);
        const double turned = face.axis.dot(moment);
        sum.sides[side].volume += {f.volume * turned, f.volume * size};
        sum.sides[side].area += {f.area * turned, f.area * size};
    }
    sum.distance = {std::min({sum.distance[0], from.norm(), to.norm()}),
                    std::max({sum.distance[1], from.norm(), to.norm()})};
}

void add_span(std::span<const Vector4d> points, bool is_sphere, const RadialFace& left,
              const RadialFace* right, RadialIntegrals& sum) {
    const PowerSpan span(points);
    std::array<Integral, 6> parts{};
    integrate_estimated(span, SpanIntegrand{is_sphere, left, right}, parts);
    sum.sides[0].volume += parts[0];
    sum.sides[0].area += parts[1];
    sum.sides[1].volume += parts[2];
    sum.sides[1].area += parts[3];
    sum.length += parts[4];
    sum.end_area += parts[5];
    const auto around = [&](double y) { return is_sphere ? y : 0.0; };
    extend_by_extreme(
        sum.distance,
        [&](double s) {
            const SpanPoint<double> p = span.at(s);
            return std::hypot(p.x, around(p.y), p.z);
        },
        [&](double s) {
            const SpanPoint<double> p = span.at(s);
            return p.x * p.x1 + around(p.y) * p.y1 + p.z * p.z1;
        });
}

RadialGap gap(std::span<const Vector4d> points, bool is_sphere, const RadialFace& left,
              const RadialFace* right) {
    const PowerSpan span(points);
    RadialGap most;
    for (const double s : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        const SpanPoint<double> p = span.at(s);
        const Ray ray = ray_to(p, is_sphere);
        const double t = std::hypot(p.x, is_sphere ? p.y : 0.0, p.z);
        const auto off = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return gap_to(f, p, ray, t); }, face);
        };
        const double l = off(left), r = right != nullptr ? off(*right) : 0;
        most.from_curve = std::max({most.from_curve, std::abs(l), std::abs(r)});
        most.apart = std::max(most.apart, std::abs(l - r));
    }
    return most;
}

}  // namespace vcell
