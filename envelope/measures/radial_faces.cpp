// Tubes over a sphere, and everything over a cylinder: what stands under a face, integrated along a ray of
// the base.
#include "radial_integrals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "../../primitives/bases/axial_terms.hpp"
#include "../lift/joined_spans.hpp"
#include "../lift/radial_patch.hpp"
#include "radial_terms.hpp"

namespace vcell {

namespace {

using span_integrals::SpanPoint;
using span_integrals::term_rounding;
using namespace radial_integrals;
using std::sqrt;

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
// The integral over first <= x <= v: faces far from the foot start at their own place.
double tube_area(double K, double E2, double first, double v) {
    return first == 0 ? tube_area(K, E2, v) : tube_area(K, E2, v) - tube_area(K, E2, first);
}
double tube_area_size(double K, double E2, double first, double v) {
    const double most2 = std::max(first * first, v * v), at_most = (K + most2) * sqrt(E2 + most2);
    return first == 0 ? tube_area_size(K, E2, v) : (std::abs(v - first) + noise * std::abs(first)) * at_most;
}

// The integral of (K + x^2)^2 over 0 <= x <= v.
double tube_square(double K, double v) {
    const double v2 = v * v;
    return v * (K * K + v2 * (2 * K / 3 + 0.2 * v2));
}
double tube_square(double K, double first, double v) { return tube_square(K, v) - tube_square(K, first); }
// That of the integral of K + x^2; times the greatest value of another factor it is one of the product.
double tube_linear_size(double K, double first, double v) {
    return (std::abs(v - first) + noise * std::abs(first)) * (K + std::max(first * first, v * v));
}

}  // namespace

namespace radial_integrals {

// ---- Cylinders over a sphere ------------------------------------------------------------------------

// K is known to rounding though the base's centre may be next to the object's surface.
TubeFace::TubeFace(const RadialBaseProblem& problem, FormId form, const Around& face) {
    const RadialForm& f = problem.family.radial_form(form);
    const auto set = [&](const auto& cylinder) {
        axis = cylinder.axis.normalized();
        foot = cylinder.point - axis.dot(cylinder.point) * axis;
        delta = side * cylinder.radius - problem.chart.radius;
    };
    side = f.is_hollow ? -1 : 1;
    if (f.is_hollow)
        set(std::get<HollowCylinder>(problem.objects[form]));
    else
        set(std::get<Cylinder>(problem.objects[form]));
    length = foot.norm();
    K = side * quotient(f.c[0], f.a[0] * f.a[0] + f.a[1] * f.a[1] + f.a[2] * f.a[2]);
    first = face.start(axis.dot(face.near));
}

// E, which cos alpha would round: E^2 is the square of c - delta e, e the unit vector towards the base at
// alpha = 0, and p = -r e. `p`: from the object's axis, across it.
template <class V>
static double edge_square(const TubeFace& f, const V& p, double r) {
    const double part = f.delta / r;
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double x = f.foot[i] + part * p[i];
        sum += x * x;
    }
    return sum;
}

double TubeFace::distance(const Ray& ray) const { return point(ray).t; }

TubeFace::Point TubeFace::point(const Ray& ray) const {
    const double B = dot(foot, ray.u) + delta, A = dot(axis, ray.u),
                 R = side * sqrt(std::max(0.0, B * B + K * A * A));
    return {A, R, side > 0 && B < 0 ? (R - B) / (A * A) : K / (B + R)};
}

// |p| = r - delta: the flux of p / 3 through the bisector is r (r - delta) / 3. The side of the base sees
// alpha and v clockwise: with r^2 d alpha = d.(y x dy), y across the axis, the boundary integral is that of G
// d alpha, G the antiderivative in v.
Share TubeFace::share(const Ray& ray) const {
    const auto [A, R, t] = point(ray);
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
    const double E2 = edge_square(*this, p, r);
    const double half = r / (K + v * v);  // 1 / (2 q)
    const double linear = v * (K + v * v / 3) - first * (K + first * first / 3);
    const double volume = half * (half * tube_square(K, first, v) - delta * linear);
    return {volume / 3 * angle, 2 * half * half * tube_area(K, E2, first, v) * angle};
}

// Sizes are those of values, times the condition of their factors, and what rounding adds to v, E and the
// angle, each by itself: products of roundings are next to nothing, though single ones may be larger than the
// values. B and A are rounded by parts of their terms, which may be far larger than R. The stretch of dp
// along u, whose terms may all but cancel, counts as the axis sees it.
Share TubeFace::size(const Ray& ray) const {
    const auto [A, signed_R, t] = point(ray);
    const double R = std::abs(signed_R), v = t * A, r = std::abs(t + delta), C = std::abs(K + v * v),
                 size_of_K = std::abs(K);
    const double half = r / C, rounding = noise * t, r2 = r * r;
    const double condition = 1 + (length + std::abs(delta)) / R + 4 * std::abs(v) * rounding / C;
    const double across = dot(foot, ray.du) / t, along = A * dot(axis, ray.du);
    const double stretch = t * t / R * std::abs(across + along),
                 terms = t * t / R * (std::abs(across) + std::abs(along)),
                 of_direction = noise * t / R * (length + std::abs(v)) * ray.rate;
    const double twist = std::abs(dot(axis, cross({foot.x(), foot.y(), foot.z()}, ray.u))) + noise * length;
    const double angle = (t + length) * (t * ray.rate + stretch) / r2,
                 off_angle = angle * condition + (terms * condition + of_direction) * twist / r2;
    Vector p;
    for (int i = 0; i < 3; ++i) p[i] = t * ray.u[i] - foot[i] - v * axis[i];
    const double E2 = edge_square(*this, p, r), E = length + std::abs(delta) * (1 + (t + length) / r);
    const double linear = tube_linear_size(size_of_K, first, v),
                 most = size_of_K + std::max(first * first, v * v);
    const double volume = half * (half * most + std::abs(delta)) / 3, area = 2 * half * half;
    return {volume * (linear * off_angle + rounding * C * angle),
            area * (tube_area_size(size_of_K, E2, first, v) * off_angle +
                    (rounding * C * sqrt(E2 + v * v) + linear * E) * angle)};
}

// At alpha E^2 is |c|^2 + delta^2 - 2 |c| delta cos alpha, of which no term is less than 0. Sizes are those
// of terms, times the condition of q.
Share TubeFace::until_tip(const BisectorTip& tip) const {
    const double end = (tip.is_far ? 1 : -1) * sqrt(-K), most = std::max(std::abs(first), std::abs(end)),
                 size_of_K = std::abs(K);
    const Share sum = sum_around([&](double cosine, double) -> Share {
        const double q = length * cosine - delta, half = 0.5 / q,
                     E2 = length * length + delta * delta - 2 * length * delta * cosine;
        const double linear = end * (K + end * end / 3) - first * (K + first * first / 3);
        const double volume = half * (half * tube_square(K, first, end) - delta * linear) / 3,
                     area = 2 * half * half * tube_area(K, E2, first, end);
        const double condition = 2 * term_rounding * (1 + (length + std::abs(delta)) / q),
                     reach = (size_of_K + most * most) * 2 * most;
        return {volume, area, condition * half * (half * (size_of_K + most * most) + std::abs(delta)) * reach,
                condition * 2 * half * half * reach * sqrt(E2 + most * most)};
    });
    const double side = tip.is_far ? -1 : 1;  // dV and dS are less than 0
    return {side * sum.volume, side * sum.area, sum.volume_rest, sum.area_rest};
}

// ---- Over a cylinder, no root ------------------------------------------------------------------------

TurnedFace::TurnedFace(const RadialBaseProblem& problem, FormId form, const Around& face) : least(infinity) {
    const auto across = [](const Vec3& p) { return Vec3(p.x(), 0, p.z()); };
    const Object& object = problem.objects[form];
    const RadialForm& f = problem.family.radial_form(form);
    is_round = false;
    slope = first = 0;
    start = face.near.y();
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const double delta = sphere->radius - problem.chart.radius;
        b = across(sphere->center);
        b0 = delta;
        K = quotient(4.0 * f.c[0] * f.c[2] - f.c[1] * f.c[1], 4.0 * f.c[2] * f.c[2]);
        start = sphere->center.y();
        first = face.start(face.near.y() - start);
        is_round = true;
        if (start >= problem.stretch[0] && start <= problem.stretch[1]) least = 0.5 * (b.norm() - delta);
        return;
    }
    if (const auto* ball = std::get_if<HollowSphere>(&object)) {
        side = -1;
        b = across(ball->center);
        b0 = -(ball->radius + problem.chart.radius);
        K = quotient(4.0 * f.c[0] * f.c[2] - f.c[1] * f.c[1], 4.0 * f.c[2] * f.c[2]);
        start = ball->center.y();
        first = face.start(face.near.y() - start);
        is_round = true;
        return;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&object)) {
        const double delta = cylinder->radius - problem.chart.radius;
        b = across(cylinder->point);
        b0 = delta;
        K = quotient(f.c[0], f.slope * f.slope);
        return;
    }
    if (const auto* tube = std::get_if<HollowCylinder>(&object)) {
        side = -1;
        b = across(tube->point);
        b0 = -(tube->radius + problem.chart.radius);
        K = -quotient(f.c[0], f.slope * f.slope);
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
        K += problem.chart.radius;
    }
}

double TurnedFace::distance(const Ray& ray) const {
    const double v = ray.y - start, C = K + v * (is_round ? v : slope);
    return C / (2.0 * (b0 + dot(b, ray.u)));
}

// beta^2 + beta'^2: in these terms nothing cancels but in the two themselves.
double TurnedFace::slope_square(const Ray& ray, double beta) const {
    const double slope_of_beta = b.x() * ray.u[2] - b.z() * ray.u[0];
    return beta * beta + slope_of_beta * slope_of_beta;
}

Share TurnedFace::share(const Ray& ray) const {
    const double along = dot(b, ray.u), beta = b0 + along, v = ray.y - start;
    const double element = -0.5 * turn(ray) / (beta * beta);
    const double H2 = slope_square(ray, beta);
    if (is_round)
        return {0.25 * tube_square(K, first, v) * element, side * tube_area(K, H2, first, v) * element};
    const double sv = slope * v;
    const double volume = v * (K * K + sv * (K + sv / 3));
    const double area = side * v * (K + 0.5 * sv) * sqrt(H2 + 0.25 * slope * slope);
    return {0.25 * volume * element, area * element};
}

Share TurnedFace::size(const Ray& ray) const {
    const double beta = b0 + dot(b, ray.u), reach = std::abs(b0) + b.norm(), H2 = slope_square(ray, beta),
                 size_of_K = std::abs(K);
    const double element = 0.5 * ray.rate / (beta * beta), condition = 1 + reach / std::abs(beta),
                 rounding = noise * std::abs(ray.y);
    if (is_round) {
        const double v = ray.y - start, C = std::abs(K + v * v);
        const double linear = tube_linear_size(size_of_K, first, v),
                     most = size_of_K + std::max(first * first, v * v);
        return {0.25 * (linear * most * condition + rounding * C * C) * element,
                (tube_area_size(size_of_K, H2, first, v) * condition + rounding * C * sqrt(H2 + v * v) +
                 linear * reach) *
                    element};
    }
    const double v = std::abs(ray.y - start) + rounding;
    const double sv = std::abs(slope) * v;
    return {0.25 * v * (K * K + sv * (size_of_K + sv)) * element * condition,
            v * (size_of_K + sv) * (std::hypot(sqrt(H2), slope) * condition + reach) * element};
}

// ---- Skew cylinders over a cylinder -----------------------------------------------------------------

AxesApart::AxesApart(const Vec3& any, const Vec3& axis) {
    const Vec3 point = any - axis.dot(any) * axis;
    square = axis.x() * axis.x() + axis.z() * axis.z();
    foot = point.y() / square;
    apart = std::abs(axis.x() * point.z() - axis.z() * point.x()) / sqrt(square);
}

// Where the axes are |delta| apart, or nearly so, C all but vanishes at the foot, and t turns within far less
// than the face: integrals start there, and y is counted from there. Next to one direction, in which A and B
// vanish, too, t grows beyond all bounds with the distance from the foot, and so does what stands between a
// face and any other height. Axes nearer than |delta| have tips beside the foot instead.
static bool is_pinched(const AxesApart& axes, double delta, const Around& face) {
    constexpr double narrow = 0x1p-4;  // a matter of digits: integrals from any height are right
    const double C = (axes.apart - delta) * (axes.apart + delta);
    return C >= 0 && C <= square(narrow * std::max(face.extent, std::abs(delta))) &&
           std::abs(axes.foot - face.near.y()) <= face.extent;
}

SkewFace::SkewFace(const RadialBaseProblem& problem, FormId form, const Cylinder& cylinder,
                   const Around& face)
    : side(1),
      origin(0),
      far_y(0),
      far_t(1),
      far_u(Vec3::Zero()),
      start(face.near.y()),
      least(infinity),
      tips(bisector_tips(problem, form)) {
    const Vec3 axis = cylinder.axis.normalized();
    const double delta = cylinder.radius - problem.chart.radius;
    const AxesApart axes(cylinder.point, axis);
    if (is_pinched(axes, delta, face)) start = origin = axes.foot;
    const Vec3 any = cylinder.point - Vec3(0, origin, 0), point = any - axis.dot(any) * axis;
    c0 = (point.norm() - delta) * (point.norm() + delta);
    c1 = -2 * point.y();
    c2 = axes.square;
    b0 = delta;
    a0 = 0;
    slope = axis.y();
    b = point;
    a = axis;
    far0 = delta;
    // C is least at the foot.
    if (axes.foot >= problem.stretch[0] && axes.foot <= problem.stretch[1] && axes.apart > std::abs(delta))
        least = 0.5 * (axes.apart - delta);
    for (const BisectorTip& tip : tips)
        if (tip.y >= problem.stretch[0] && tip.y <= problem.stretch[1]) least = tip.reach;
}

// y is counted from the face: C may be next to nothing there, as where the base is next to the wall. It falls
// to nothing beyond the stretch, where t is none. No bisector has a least distance within the stretch: where
// the base is nearest to the wall about its axis, along the axis there are nearer ones.
SkewFace::SkewFace(const RadialBaseProblem& problem, FormId vessel, const Around& face)
    : side(-1),
      origin(std::clamp(face.near.y(), problem.stretch[0], problem.stretch[1])),
      start(origin),
      least(infinity),
      tips(bisector_tips(problem, vessel)) {
    const AxialTerms terms(problem, vessel, origin);
    c0 = terms.c[0];
    c1 = terms.c[1];
    c2 = terms.c[2];
    b0 = terms.b0;
    a0 = terms.a0;
    slope = terms.slope;
    b = terms.b;
    a = terms.a;
    if (const auto* tube = std::get_if<HollowCylinder>(&problem.objects[vessel])) {
        far0 = -(tube->radius + problem.chart.radius);
        far_t = 1;
        far_y = 0;
        far_u = Vec3::Zero();
        return;
    }
    // K times it is S w.(p - apex) - t + R0.
    const auto& cone = std::get<HollowCone>(problem.objects[vessel]);
    const Vec3 axis = cone.axis.stableNormalized();
    const double S = cone.sine(), K = cone.cosine();
    far0 = (S * axis.dot(Vec3(0, origin, 0) - cone.apex) + problem.chart.radius) / K;
    far_y = S * axis.y() / K;
    far_t = -1 / K;
    far_u = S / K * axis;
}

// C q^2 - 2 B q - A^2 = 0, or + A^2 in a vessel, in one direction w: A is constant, B = B0 + slope A y, C
// quadratic in y. With derivatives by the angle.
struct SkewSlice {
    double C0, c1, c2, slope, side;
    double A, B0, dA, dB0;

    SkewSlice(const SkewFace& f, const Ray& ray)
        : C0(f.c0),
          c1(f.c1),
          c2(f.c2),
          slope(f.slope),
          side(f.side),
          A(dot(f.a, ray.u) + f.a0),
          B0(dot(f.b, ray.u) + f.b0),
          dA(f.a.x() * ray.u[2] - f.a.z() * ray.u[0]),
          dB0(f.b.x() * ray.u[2] - f.b.z() * ray.u[0]) {}
};

struct SkewPoint {
    double t, t_y, dS;
};

static SkewPoint skew_point(const SkewSlice& s, double y) {
    const double C = s.C0 + y * (s.c2 * y + s.c1), half_C_y = s.c2 * y + 0.5 * s.c1;
    // At a tip R is zero, and what is divided by it, too: rounding leaves as much of R as this.
    constexpr double unsure = std::numeric_limits<double>::epsilon();
    const double B = s.B0 + s.slope * s.A * y,
                 R = sqrt(std::max(unsure * B * B, B * B + s.side * s.A * s.A * C));
    const double t = s.side > 0 && B < 0 ? (R - B) / (s.A * s.A) : C / (B + R);
    const double turn = ((s.dB0 + s.slope * s.dA * y) + s.side * s.A * s.dA * t) / R;
    const double t_y = (half_C_y - s.slope * s.A * t) / R;
    return {t, t_y, t * sqrt(1 + turn * turn + t_y * t_y)};
}

double SkewFace::distance(const Ray& ray) const {
    return skew_point(SkewSlice(*this, ray), ray.y - origin).t;
}

// SkewFace's, in one direction.
struct FromAxis {
    double zero, along_y, along_t;

    FromAxis(const SkewFace& f, const Ray& ray)
        : zero(f.far0), along_y(f.far_y), along_t(f.far_t + dot(f.far_u, ray.u)) {}
    double operator()(double y, double t) const { return std::abs(zero + along_y * y + along_t * t); }
};

// How far y may move, in the complex plane, before t or its slope becomes singular: to the zeros of the
// radicand B^2 + A^2 C = A^2 y^2 + 2 h y + k, and to where the surface element vanishes: the square of the
// unit vectors' difference w - w_i, which changes by the surface's own slope over its distance from the
// object's axis.
static double room(const SkewSlice& s, const SkewPoint& p, const FromAxis& from_axis, double y) {
    const double A2 = s.A * s.A, side = s.side * A2, lead = s.slope * s.slope * A2 + side * s.c2,
                 h = s.B0 * s.slope * s.A + 0.5 * side * s.c1, k = s.B0 * s.B0 + side * s.C0;
    const double discriminant = h * h - lead * k, value = (lead * y + 2 * h) * y + k;
    // |value| = lead |y - y1| |y - y2|: of conjugate zeros both distances are the same.
    const double derivative = 2 * (std::abs(lead * y + h) + sqrt(std::abs(discriminant)));
    const double to_zeros = discriminant < 0 ? sqrt(value / lead) : 2 * value / derivative;
    const double cosine = p.t / p.dS;  // of the angle between w and the normal
    const double to_vertical = cosine * 2 * from_axis(y, p.t) / sqrt(1 + p.t_y * p.t_y);
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

// In parts that keep clear of singularities, as many as the budget allows: where it is less than zero
// afterwards, the value means nothing.
static Share tame_integral(const SkewSlice& s, const FromAxis& from_axis, double from, double to,
                           int& budget) {
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    const double r = room(s, skew_point(s, middle), from_axis, middle);
    // On an ellipse within 7 half lengths 8 points do what 16 do within 2.5 (quadrature.hpp).
    if (r >= 7 * std::abs(half)) return skew_rule<8>(s, middle, half);
    if (r >= quadrature::required_reach * std::abs(half))
        return skew_rule<quadrature::points>(s, middle, half);
    if (--budget < 0) return {0, 0};
    const Share a = tame_integral(s, from_axis, from, middle, budget);
    if (budget < 0) return a;
    const Share b = tame_integral(s, from_axis, middle, to, budget);
    return {a.volume + b.volume, a.area + b.area};
}

// Where the surface is steep all along, or nearly singular, so that parts of that kind would be too many:
// those are halved first of which two rules differ most, and what the rest leaves out is told from the rules.
class SteepIntegral {
public:
    SteepIntegral(const SkewSlice& slice, double from, double to) : slice_(slice) {
        const Share whole = skew_rule<quadrature::points>(slice, 0.5 * (from + to), 0.5 * (to - from));
        scale_ = {1 / std::abs(whole.volume), 1 / std::abs(whole.area)};
        push(from, to);
        while (count_ < most_parts && parts_[0].weight > 0) {
            std::pop_heap(parts_.begin(), parts_.begin() + count_);
            const Part worst = parts_[--count_];
            const double middle = 0.5 * (worst.from + worst.to);
            push(worst.from, middle);
            push(middle, worst.to);
        }
    }

    Share value() const {
        Share sum{0, 0};
        for (int i = 0; i < count_; ++i) {
            const Share& part = parts_[i].value;
            sum.volume += part.volume;
            sum.area += part.area;
            sum.volume_rest += part.volume_rest;
            sum.area_rest += part.area_rest;
        }
        return sum;
    }

private:
    static constexpr int most_parts = 256;

    struct Part {
        double from, to;
        Share value;
        double weight;  // of what its rule leaves out; 0 where halving is of no more use

        bool operator<(const Part& o) const { return weight < o.weight; }
    };

    // The rules converge geometrically, and 16 points have twice the degree of 8: ten times the square of
    // the difference, as integrate_estimated() has it.
    static double rest(double fine, double coarse) {
        const double difference = std::abs(fine - coarse), size = std::abs(fine);
        return difference < size ? std::min(difference, 10 * difference * (difference / size)) : difference;
    }

    void push(double from, double to) {
        const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
        const Share coarse = skew_rule<8>(slice_, middle, half);
        Share fine = skew_rule<quadrature::points>(slice_, middle, half);
        fine.volume_rest = rest(fine.volume, coarse.volume);
        fine.area_rest = rest(fine.area, coarse.area);
        // Next to nothing of the whole.
        constexpr double enough = std::numeric_limits<double>::epsilon() / most_parts;
        const double weight = std::max(fine.volume_rest * scale_.volume, fine.area_rest * scale_.area);
        parts_[count_++] = {from, to, fine, weight > enough ? weight : 0};
        std::push_heap(parts_.begin(), parts_.begin() + count_);
    }

    const SkewSlice& slice_;
    Share scale_{};
    std::array<Part, most_parts> parts_;
    int count_ = 0;
};

Share SkewFace::share(const Ray& ray) const {
    const SkewSlice slice(*this, ray);
    const double from = start - origin, to = ray.y - origin;
    int budget = 64;
    Share s = tame_integral(slice, FromAxis(*this, ray), from, to, budget);
    if (budget < 0) s = SteepIntegral(slice, from, to).value();
    const double angle = turn(ray), size = std::abs(angle);
    return {-s.volume * angle, -s.area * angle, s.volume_rest * size, s.area_rest * size};
}

Share SkewFace::size(const Ray& ray) const {
    const SkewSlice s(*this, ray);
    const SkewPoint a = skew_point(s, start - origin), b = skew_point(s, ray.y - origin);
    const double t = std::max(a.t, b.t), dS = std::max(a.dS, b.dS);
    const double height = std::abs(ray.y - start) + noise * std::abs(ray.y);
    Share sum{0.5 * t * t * height, dS * height};
    if (side < 0) {  // t may be greatest in between
        const double from = start - origin, to = ray.y - origin;
        const Share whole = skew_rule<8>(s, 0.5 * (from + to), 0.5 * (to - from));
        sum.volume = std::max(sum.volume, std::abs(whole.volume));
        sum.area = std::max(sum.area, std::abs(whole.area));
    }
    return {sum.volume * ray.rate, sum.area * ray.rate};
}

bool SkewFace::may_pass_tip(const span_integrals::PowerSpan& span) const {
    using Eigen::Vector4d;
    if (tips.empty()) return false;
    const auto control = span.control_points();
    const std::span points(control.data(), static_cast<std::size_t>(span.degree()) + 1);
    if (!std::ranges::all_of(points, [](const Vector4d& p) { return p.w() > 0; })) return true;
    return std::ranges::any_of(tips, [&](const BisectorTip& tip) {
        double least = infinity, most = -infinity;
        for (const Vector4d& p : points) {
            const double across = (tip.u.z() * p.x() - tip.u.x() * p.z()) / p.w();
            least = std::min(least, across);
            most = std::max(most, across);
        }
        // Next to the tip's direction rules converge to what they see as to what has its pole there.
        constexpr double well_off = 0x1p-3;
        if (least > 0 ? least >= well_off * most : most < 0 && most <= well_off * least) return false;
        const auto is_behind = [&](const Vector4d& p) { return tip.u.x() * p.x() + tip.u.z() * p.z() < 0; };
        if (std::ranges::all_of(points, is_behind)) return false;
        // On the side where integrals start, unless these start all but in the tip.
        constexpr double well_apart = 0x1p-6;
        const double off = start - tip.y;
        return !std::ranges::all_of(points, [&](const Vector4d& p) {
            const double y = p.y() / p.w() - tip.y;
            return y * off > 0 && well_apart * std::abs(y) <= std::abs(off);
        });
    });
}

}  // namespace radial_integrals

RadialFace make_radial_face(const RadialBaseProblem& problem, FormId form,
                            const radial_integrals::Around& face) {
    using namespace radial_integrals;
    const auto* cylinder = std::get_if<Cylinder>(&problem.objects[form]);
    if (problem.chart.is_sphere()) {
        if (std::holds_alternative<HollowCone>(problem.objects[form])) return ConeFace(problem, form, face);
        if (!problem.family.is_circular(form)) return TubeFace(problem, form, face);
        return RoundFace(problem, form);
    }
    if (is_vessel(problem.objects[form]) && problem.family.radial_form(form).has_root())
        return SkewFace(problem, form, face);
    const bool is_skew = cylinder != nullptr && (cylinder->axis.x() != 0 || cylinder->axis.z() != 0);
    if (is_skew) {
        const SkewFace skew(problem, form, *cylinder, face);
        if (const auto graph = GraphFace::of(problem, form, skew, face)) return *graph;
        return skew;
    }
    if (is_wall(problem, form)) return FlatFace(std::get<Plane>(problem.objects[form]), face.near);
    if (const auto half_way = FlatFace::to_twin(problem, form, face)) return *half_way;
    return TurnedFace(problem, form, face);
}

double least_distance(const RadialFace& face) {
    return std::visit([](const auto& f) { return f.least_distance(); }, face);
}

}  // namespace vcell
