// Spheres, planes and walls over a sphere: surfaces of revolution, along conics and segments.
#include "radial_integrals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "../lift/joined_spans.hpp"
#include "../lift/radial_patch.hpp"
#include "half_rules.hpp"
#include "radial_terms.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;
using span_integrals::term_rounding;
using namespace radial_integrals;
using std::sqrt;

constexpr double square(double x) { return x * x; }

}  // namespace

namespace radial_integrals {

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
    if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        delta = vessel->radius + problem.chart.radius;
        c = vessel->center.norm();
        const double power = ball_power(problem, form);
        d1 = 0.5 * power / (delta + c);
        d2 = 0.5 * (delta + c);
        root = 0.5 * sqrt(power);
        k = 0.5 * power;
        e0 = delta;
        e1 = c;
        if (c == 0) {
            set_concentric(0.5 * delta);
            return;
        }
        shape = Shape::Ellipsoid;
        axis = -vessel->center / c;
        return;
    }
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        delta = sphere->radius - problem.chart.radius;
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
    if (!is_wall(problem, form)) {
        shape = Shape::Paraboloid;
        k = distance + problem.chart.radius;
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

void RoundFace::set_concentric(double t) {
    shape = Shape::Closed;
    axis = Vec3::UnitZ();
    d1 = d2 = root = t;
    delta = e0 = 2 * t;
    k = 2 * t * t;
    c = e1 = 0;
}

double RoundFace::distance(const Ray& ray) const { return k / (e0 + e1 * dot(axis, ray.u)); }

// The form f(t) b.(p x dp) has the derivative f' dt ^ b.(p x dp) + f b.(dp x dp), of size t |f'| + 2 f at
// most. Of a hyperboloid, c (t + d1) / (12 (t + d2)) has t |f'| < c |delta| / (12 (t + d2)), and lies between
// its values at the ends of a stretch.
double RoundFace::volume_slope(double near, double far) const {
    switch (shape) {
        case Shape::Flat: return d1 / 3;
        case Shape::Paraboloid: return (3 * far + 2 * d1) / 12;
        case Shape::Ellipsoid: {
            // The derivative of (t + d1) / (d2 - t) is delta / (d2 - t)^2.
            const double room = d2 - far;
            return room > 0 ? c / 12 * (2 * (far + d1) + delta * far / room) / room : infinity;
        }
        case Shape::Closed:  // c (t + delta) / (12 t), and the solid angle
            return c / 12 * (2 + 3 * delta / near) + mean().volume / (near * near);
        case Shape::Hyperboloid: break;
    }
    const double most = std::max((near + d1) / (near + d2), (far + d1) / (far + d2));
    return c / 12 * (2 * most + std::abs(delta) / (near + d2));
}

// Areas change by as much of the factors f below.
//
// *Hyperboloids.* f = c / (2 root) M / (t + d2), M the mean of r(x) = sqrt(x (x + delta)) from d1 to t, which
// grows and is concave. Its slope is that of r at d1, c / (2 root), by half at most; and as t M' is the mean
// of t (x - d1) / (t - d1) r' <= x r', at most M times the largest of x r' / r, which is 1, or c / (2 d2)
// where delta < 0. What t + d2 takes is no more than f.
//
// *Paraboloids.* With x = sqrt(t / d1), t f' = x^2 (x + 2) / (6 (x + 1)^2) < f / 2, and f grows.
//
// *Ellipsoids.* r(x) = sqrt(x (delta - x)) has root <= r <= delta / 2 and a slope of c / (2 root) at most
// from d1 to d2, its mean M half of that.
//
// *Closed ones.* Over the unit sphere the form is g b.(u x du) with g = (m1 - m2) / 2, of size |g'| + 2 |g|,
// and the mean times the solid angle. With h(z) = dS / d omega = t^2 sqrt(t (delta - t)) / root,
//     dh / dz = -c / (4 d1 d2 root) q,   q = t^3.5 (5 delta - 6 t) / sqrt(delta - t);
// q is 0.4222 delta^4 at most, at t = 0.684 delta, and falls from there on to its value at d2: H, the largest
// slope, is known. Means over both sides of z have middles 1 apart, so 2 |g| <= H, and each one's slope is
// half of that at most.
double RoundFace::area_slope(double near, double far) const {
    switch (shape) {
        case Shape::Flat: return 1;
        case Shape::Paraboloid: return 2.5 * factors(far).area;
        case Shape::Ellipsoid: {
            const double room = d2 - far;
            if (!(room > 0)) return infinity;
            return c / (2 * root * room) * (far * c / (4 * root) + 0.5 * delta * (2 + far / room));
        }
        case Shape::Closed: {
            const double inner = 0.4222 * square(square(delta)),
                         last = square(d2) * d2 * sqrt(d2 / d1) * std::abs(5 * delta - 6 * d2),
                         slope = 0.25 * c / (d1 * d2 * root) * std::max(inner, last);
            return (1.5 * slope + mean().area) / (near * near);
        }
        case Shape::Hyperboloid: break;
    }
    const double scale = 0.5 * c / root, factor = scale * sqrt(far * (far + std::abs(delta))) / (near + d2),
                 part = delta < 0 ? std::max(1.0, 0.5 * c / d2) : 1,
                 growth = std::min(part * factor, 0.5 * scale * scale * far / (far + d2));
    return 2 * factor + std::max(factor, growth);
}

static double largest(double x) { return x; }
template <class Derived>
double largest(const Eigen::ArrayBase<Derived>& x) {
    return x.maxCoeff();
}

static double not_below(double x, double least) { return std::max(x, least); }
template <class Derived>
static Derived not_below(const Eigen::ArrayBase<Derived>& x, double least) {
    return x.max(least);
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

// asin(y) / y - 1, by its series up to y^2 = 1 / 16, relative truncation 2^-43 and less; from there on by
// asin(y) = 2 asin(z) with z = y / sqrt(2 (1 + sqrt(1 - y^2))).
template <class T>
static T asin_excess(const T& square, int halvings = 8) {
    if (!(largest(square) > 0.0625) || halvings == 0)
        return square *
               (1.0 / 6 +
                square *
                    (3.0 / 40 +
                     square *
                         (5.0 / 112 +
                          square *
                              (35.0 / 1152 +
                               square * (63.0 / 2816 +
                                         square * (231.0 / 13312 +
                                                   square * (143.0 / 10240 +
                                                             square * (6435.0 / 557056 +
                                                                       square * (12155.0 / 1245184 +
                                                                                 square * (46189.0 /
                                                                                           5505024))))))))));
    const T cosine = 1 + sqrt(1 - square), stretch = sqrt(2 / cosine);
    // stretch - 1, of which nothing cancels.
    const T more = square / (cosine * cosine * (1 + stretch));
    return more + stretch * asin_excess(T(square / (2 * cosine)), halvings - 1);
}

// With x = delta sin^2 a the mean of sqrt(x (delta - x)) from d1 to t is, with h the half of how far 2 a goes
// and P = sqrt(t d2) + sqrt((delta - t) d1),
//
//     sin h = y = (t - d1) / P,   cos h = (sqrt((delta - t) d2) + sqrt(t d1)) / delta,
//     M = (P cos h + delta^2 / (2 P) (asin(y) / y - cos h)) / 2.
template <class T>
static T ellipsoid_mean(const RoundFace& f, const T& t) {
    const T rest = f.delta - t, P = sqrt(t * f.d2) + sqrt(rest * f.d1), y = (t - f.d1) / P,
            cosine = (sqrt(rest * f.d2) + sqrt(t * f.d1)) * (1 / f.delta);
    const T y2 = y * y, more = asin_excess(y2) + y2 / (1 + cosine);
    return 0.5 * (P * cosine + 0.5 * f.delta * f.delta * more / P);
}

// A spheroid's semi-axes are delta / 2 and sqrt(d1 d2).
Share RoundFace::mean() const {
    const double long_axis = 0.5 * delta, flatness = c / delta;
    return {d1 * d2 * delta / 6, 0.5 * root * (root + long_axis * (1 + asin_excess(flatness * flatness)))};
}

// (m1 - m2) / 2. The area up to the near pole, over d phi, is 2 root / c (t - d1) M(t) = (1 - z) m1, that up
// to the far one the same with d2 - t and M(delta - t), and t - d1 = c (1 - z) t / (2 d2), d2 - t = c (1 + z)
// t / (2 d1). As S0 is half of (1 - z) m1 + (1 + z) m2, it is either of
//
//     (root t M(t) / d2 - S0) / (1 + z),      (S0 - root t M(delta - t) / d1) / (1 - z),
//
// of which the first is taken up to the middle, where d2 - t is c / 2 at least, the other one from there on.
template <class T>
static T near_excess(const RoundFace& f, const T& t) {
    return (f.root / f.d2 * t * ellipsoid_mean(f, t) - f.mean().area) *
           (f.c / (2 * f.d1) * t / not_below(T(f.d2 - t), 0.25 * f.c));
}
template <class T>
static T far_excess(const RoundFace& f, const T& t) {
    return (f.mean().area - f.root / f.d1 * t * ellipsoid_mean(f, T(f.delta - t))) *
           (f.c / (2 * f.d2) * t / not_below(T(t - f.d1), 0.25 * f.c));
}
static double area_excess(const RoundFace& f, double t) {
    return t <= 0.5 * f.delta ? near_excess(f, t) : far_excess(f, t);
}
template <class Derived>
static Derived area_excess(const RoundFace& f, const Eigen::ArrayBase<Derived>& t) {
    return (t <= 0.5 * f.delta)
        .select(near_excess<Derived>(f, t.derived()), far_excess<Derived>(f, t.derived()));
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
        case Shape::Ellipsoid: {
            const T over = 1 / (d2 - t);
            return {T(c / 12 * (t + d1) * over), T(c / (2 * root) * ellipsoid_mean(*this, t) * over)};
        }
        case Shape::Closed:
            if (c == 0) return {T(0 * t), T(0 * t)};
            return {T(-c / 12 * (1 + delta / t)), T(area_excess(*this, t) / (t * t))};
        case Shape::Hyperboloid: break;
    }
    const T r = sqrt(t * (t + delta)), reciprocal = 1 / (root + r), y = (t - d1) * reciprocal;
    const T over = 1 / (t + d2), excess = atanh_excess(T(y * y));
    const T mean = 2 * r + reciprocal * (d2 * (3 * d1 + t) + d1 * (t - d1) - delta * delta * excess);
    return {T(c / 12 * (t + d1) * over), T(c / (8 * root) * mean * over)};
}

// Bounds of both factors where t stays off the cut.
static Share factor_bounds(const RoundFace& f, double least, double most) {
    using Shape = RoundFace::Shape;
    if (f.shape == Shape::Flat) return {f.d1 / 6, 0.5};
    if (f.is_closed() && f.c == 0) return {0, 0};
    most = std::max(most, f.d1);
    if (f.is_ellipsoid()) {
        if (!(least > 0 && most < f.d2)) return {infinity, infinity};
        // What rounding leaves of d2 - t counts.
        const double over = (1 + f.d2 / (f.d2 - most)) / (f.d2 - most);
        return {f.c / 12 * (most + f.d1) * over, f.c * 0.5 * f.delta / (2 * f.root) * over};
    }
    if (f.is_closed()) {
        if (!(least > 0 && most < f.delta)) return {infinity, infinity};
        // Means of dS / d omega = t^2 sqrt(t (delta - t)) / root are over places where 1 / t is between that
        // of the disk and that of a pole: its real part is 1 / T at least, so |t| <= T and |delta - t| <=
        // delta.
        const double T = std::max(most, f.d2);
        return {f.c / 12 * (1 + f.delta / least), square(T / least) * sqrt(T * f.delta) / f.root};
    }
    if (!(least > std::max(0.0, -f.delta))) return {infinity, infinity};
    if (f.shape == Shape::Paraboloid) return {(most + f.d1) / 12, 0.5 * sqrt(most / f.d1)};
    const double scale = f.c / (least + f.d2);
    return {scale / 12 * (most + f.d1), scale * sqrt(most * (most + std::abs(f.delta))) / (2 * f.root)};
}

void RoundFace::choose_integrals(const std::array<double, 2>& distance) {
    if (!is_ellipsoid()) return;
    RoundFace closed = *this;
    closed.shape = Shape::Closed;
    const auto bound = [&](const RoundFace& f) { return factor_bounds(f, distance[0], distance[1]).area; };
    if (distance[1] < distance[0] || bound(closed) < bound(*this)) shape = Shape::Closed;
}

Share RoundFace::share(const Ray& ray) const {
    const double t = distance(ray), element = t * t * dot(axis, cross(ray.u, ray.du));
    const Factors<double> f = factors(t);
    return {f.volume * element, f.area * element};
}

Share RoundFace::size(const Ray& ray) const {
    const double t = distance(ray), condition = (1 + (std::abs(e0) + std::abs(e1)) * t / k) *
                                                (is_ellipsoid() ? d2 / std::abs(d2 - t) : 1);
    const double element = t * t * ray.rate * condition;
    // A closed one's area factor may be next to nothing, a difference of what its bound is of the size of.
    const Share f = is_closed() ? factor_bounds(*this, t, t) : Share{factors(t).volume, factors(t).area};
    return {f.volume * element, f.area * element};
}

}  // namespace radial_integrals

namespace {

// (p, t, w), homogeneous.
using ConicPoint = Eigen::Matrix<double, 5, 1>;

// Aimed at for the truncation of one span, as a part of the integrand's size: 1e-12, and the bounds are some
// hundred times the error. What is reported is the bound that is reached.
constexpr double aim = 0x1p-40;

// Nothing that the integrands divide by or take the root of changes by more than this part over a disk.
constexpr double tame_part = 0.75;
constexpr double widest_disk = 16, least_disk = 1.375;  // radii; the span is [-1, 1]

// A quadratic, and a bound of how far it is from its value at 0 for |s| <= r.
struct Quadratic {
    double c0, c1, c2;

    template <class T>
    T operator()(const T& s) const {
        return c0 + s * (c1 + s * c2);
    }
    double deviation(double r) const { return r * (std::abs(c1) + r * std::abs(c2)); }
};

using Values = HalfRule::Values;

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
    void add(const RoundFace& left, const RoundFace& right, RadialIntegrals& sum, int halvings,
             int& budget) const {
        const double middle_t = t_.c0 / w_.c0;
        // w (t - middle_t).
        const Quadratic turned{0, t_.c1 - middle_t * w_.c1, t_.c2 - middle_t * w_.c2};
        const double r =
            disk(turned, std::min({middle_t - std::max({0.0, -left.delta, -right.delta}),
                                   room_before_end(left, middle_t), room_before_end(right, middle_t)}));
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
        for (; points < HalfRule::most_points && !(truncated * moment <= needed); points += 2)
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
        add_values(points, left, right, sum);
    }

    static double room_before_end(const RoundFace& face, double t) {
        return face.is_closed() ? face.delta - t : face.is_ellipsoid() ? face.d2 - t : infinity;
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

    void add_values(int points, const RoundFace& left, const RoundFace& right, RadialIntegrals& sum) const {
        const HalfRule& rule = HalfRule::of(points);
        const std::array faces{&left, &right};
        std::array<Quadratic, 2> along;
        for (const int side : {0, 1}) {
            const Vec3& axis = faces[side]->axis;
            along[side] = {axis.dot(x_[0]), axis.dot(x_[1]), axis.dot(x_[2])};
        }
        const auto& v = speed2_;
        Values length = Values::Zero();
        std::array<RoundFace::Factors<Values>, 2> sums;
        sums.fill({Values::Zero(), Values::Zero()});
        for (std::size_t first = 0; first < rule.x.size(); first += HalfRule::pairs_at_once) {
            const auto [s, rule_weight] = rule.group(first);
            const Values reciprocal = 1 / w_(s), t = t_(s) * reciprocal,
                         weight = rule_weight * reciprocal.square();
            length += weight * sqrt(v[0] + s * (v[1] + s * (v[2] + s * (v[3] + s * v[4]))));
            for (const int side : {0, 1}) {
                const Values element = weight * along[side](s);
                const RoundFace::Factors<Values> f = faces[side]->factors(t);
                sums[side].volume += element * f.volume;
                sums[side].area += element * f.area;
            }
        }
        sum.length += {length.sum(), term_rounding * length.sum()};
        for (const int side : {0, 1}) {
            sum.sides[side].volume.value += sums[side].volume.sum();
            sum.sides[side].area.value += sums[side].area.sum();
        }
    }

    Powers a_;
    Quadratic t_, w_;
    std::array<Vec3, 3> x_;
    std::array<double, 5> speed2_;
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

}  // namespace vcell
