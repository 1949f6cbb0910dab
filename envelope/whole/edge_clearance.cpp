#include "edge_clearance.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/wide.hpp"
#include "distance_gradient.hpp"

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

struct Range {
    double low = infinity, high = -infinity;

    void extend(double x) {
        low = std::min(low, x);
        high = std::max(high, x);
    }
};

// Bounds the distance from an object along a Bezier span, but for a few roundings of coordinates.
class DistanceAlong {
public:
    explicit DistanceAlong(const Object& object) : object_(object) {
        if (const auto* tube = std::get_if<Cylinder>(&object)) axis_ = tube->axis.stableNormalized();
        if (const auto* ball = std::get_if<Sphere>(&object)) radius_ = ball->radius;
        if (const auto* tube = std::get_if<Cylinder>(&object)) radius_ = tube->radius;
    }

    Range operator()(const RationalCurve3& span) const {
        Range range;
        if (const auto* plane = std::get_if<Plane>(&object_)) {
            const Vec3 n = plane->normal.stableNormalized();
            for (const Eigen::Vector4d& c : span.points) range.extend(n.dot(c.head<3>() - plane->point));
            if (range.high <= 0) return {-range.high, -range.low};
            return range.low >= 0 ? range : Range{0, std::max(-range.low, range.high)};
        }
        // Coefficient k of |p|^2 w^2 is the sum of C(n, i) C(n, k - i) w_i w_(k - i) p_i p_(k - i) over i,
        // but for a factor that that of w^2 has, too.
        const std::size_t n = span.points.size() - 1;
        std::vector<Vec3> arms;
        std::vector<double> weights;
        double binomial = 1, longest = 0;
        for (std::size_t i = 0; i <= n; ++i) {
            const Vec3 arm = span.points[i].head<3>() - place_of(object_);
            arms.push_back(axis_ ? Vec3(arm - axis_->dot(arm) * *axis_) : arm);
            longest = std::max(longest, arms.back().squaredNorm());
            weights.push_back(binomial * span.points[i][3]);
            binomial *= static_cast<double>(n - i) / static_cast<double>(i + 1);
        }
        for (std::size_t k = 0; k <= 2 * n; ++k) {
            double squared = 0, weight = 0;
            for (std::size_t i = k < n ? 0 : k - n; i <= std::min(k, n); ++i) {
                const double w = weights[i] * weights[k - i];
                squared += w * arms[i].dot(arms[k - i]);
                weight += w;
            }
            range.extend(squared / weight);
        }
        // Where the span comes near to the centre or the axis these products cancel.
        const double slack = 64 * std::numeric_limits<double>::epsilon() * longest;
        return {std::sqrt(std::max(0.0, range.low - slack)) - radius_,
                std::sqrt(std::max(0.0, range.high) + slack) - radius_};
    }

private:
    const Object& object_;
    std::optional<Vec3> axis_;  // none: distances are from a point
    double radius_ = 0;
};

std::vector<RationalCurve3> spans_of(const RationalCurve3& curve) {
    std::vector<RationalCurve3> spans;
    for (std::size_t i = 0; i + 1 < curve.knots.size(); ++i)
        if (curve.knots[i] < curve.knots[i + 1])
            spans.push_back(restricted(curve, curve.knots[i], curve.knots[i + 1]));
    return spans;
}

struct LeastAlong {
    Interval value;
    double parameter;  // of a span that may have it
};

// Encloses the least value along a curve. `bounds` gives a span's, `enough` is how narrow they need be.
template <class Bounds>
LeastAlong least_along(const RationalCurve3& curve, double enough, Bounds bounds) {
    struct Span {
        RationalCurve3 curve;
        double low;
        bool operator<(const Span& other) const { return low > other.low; }  // the least one comes first
    };
    std::priority_queue<Span> waiting;
    double known = infinity, parameter = curve.domain_begin();  // the least value is no larger
    const auto add = [&](RationalCurve3 span) {
        const Range range = bounds(span);
        if (range.high < known) {
            known = range.high;
            parameter = std::midpoint(span.domain_begin(), span.domain_end());
        }
        if (range.low <= known) waiting.push({std::move(span), range.low});
    };
    for (RationalCurve3& span : spans_of(curve)) add(std::move(span));
    // Far more than the halvings down to roundings of a handful of places that are about as narrow.
    constexpr int most_halvings = 4096;
    for (int n = 0; n < most_halvings && !waiting.empty() && known - waiting.top().low > enough; ++n) {
        const RationalCurve3 span = waiting.top().curve;
        const double begin = span.domain_begin(), end = span.domain_end(), middle = std::midpoint(begin, end);
        if (!(begin < middle && middle < end)) break;
        waiting.pop();
        add(restricted(span, begin, middle));
        add(restricted(span, middle, end));
    }
    return {{waiting.empty() ? known : std::min(known, waiting.top().low), known}, parameter};
}

double size_of(const RationalCurve3& curve) {
    double size = 0;
    for (const Eigen::Vector4d& c : curve.points) size = std::max(size, c.head<3>().cwiseAbs().sum());
    return size;
}
// Bounds what some operations on coordinates as large as that lose when spans are halved and bounded.
double rounding_of(double size) { return 64 * std::numeric_limits<double>::epsilon() * size; }

struct ExtremesAlong {
    Extremes values;
    double parameter;  // next to the least one
};

// Encloses the values along an arc that is no farther from the curve than `off`, if they change no faster
// than places.
template <class Bounds>
ExtremesAlong extremes_along(const RationalCurve3& curve, double off, Bounds bounds) {
    const auto opposite = [&](const RationalCurve3& span) {
        const Range range = bounds(span);
        return Range{-range.high, -range.low};
    };
    const Interval blur(-off, off);
    const LeastAlong least = least_along(curve, off, bounds);
    return {{least.value + blur, -least_along(curve, off, opposite).value + blur}, least.parameter};
}

// ---- The narrowest place of a trisector

// The distance from a convex object about a point.
struct ConvexDistance {
    double value;
    Vec3 gradient;
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    double arm = infinity;  // from the centre or the axis: the hessian is no larger than its inverse
};

std::optional<ConvexDistance> convex_distance(const Object& object, const Vec3& p) {
    if (is_vessel(object)) return std::nullopt;
    const auto [gradient, arm] = distance_gradient(object, p);
    ConvexDistance d{distance_from(object, p), gradient, Eigen::Matrix3d::Zero(), arm};
    if (std::holds_alternative<Plane>(object)) return d;
    d.hessian = Eigen::Matrix3d::Identity() - gradient * gradient.transpose();
    if (const auto* tube = std::get_if<Cylinder>(&object)) {
        const Vec3 axis = tube->axis.stableNormalized();
        d.hessian -= axis * axis.transpose();
    }
    d.hessian /= arm;
    return d;
}

// Where a trisector may have its least clearance, and the mean of gradients that all but vanishes there.
struct NarrowPlace {
    Vec3 point;
    std::array<ConvexDistance, 3> distances;
    std::array<double, 3> weights;

    double clearance() const {
        return weights[0] * distances[0].value + weights[1] * distances[1].value +
               weights[2] * distances[2].value;
    }
    double slope() const {
        return (weights[0] * distances[0].gradient + weights[1] * distances[1].gradient +
                weights[2] * distances[2].gradient)
            .norm();
    }
};

// By Newton's steps for the conditions of Lagrange; none where they lead to no mean. Nothing is proved here.
std::optional<NarrowPlace> narrow_place_near(const std::array<const Object*, 3>& objects, Vec3 p) {
    constexpr int steps = 8;
    NarrowPlace narrowest;
    Eigen::Vector2d weights(1.0 / 3, 1.0 / 3);  // of the second and the third object
    for (int n = 0;; ++n) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::optional<ConvexDistance> d = convex_distance(*objects[i], p);
            if (!d || !std::isfinite(d->value) || !(d->arm > 0)) return std::nullopt;
            narrowest.distances[i] = *d;
        }
        const auto& [own, first, second] = narrowest.distances;
        Eigen::Matrix<double, 3, 2> across;
        across << first.gradient - own.gradient, second.gradient - own.gradient;
        // Weights as good as they can be in this point, before and after the steps.
        if (n == 0 || n == steps) weights = across.colPivHouseholderQr().solve(-own.gradient);
        if (n == steps) break;
        const double rest = 1 - weights.sum();
        Eigen::Matrix<double, 5, 5> system = Eigen::Matrix<double, 5, 5>::Zero();
        system.topLeftCorner<3, 3>() =
            rest * own.hessian + weights[0] * first.hessian + weights[1] * second.hessian;
        system.topRightCorner<3, 2>() = across;
        system.bottomLeftCorner<2, 3>() = across.transpose();
        Eigen::Matrix<double, 5, 1> residual;
        residual << own.gradient + across * weights, first.value - own.value, second.value - own.value;
        const Eigen::Matrix<double, 5, 1> step = system.fullPivLu().solve(-residual);
        if (!step.allFinite()) return std::nullopt;
        p += step.head<3>();
        weights += step.tail<2>();
    }
    narrowest.point = p;
    narrowest.weights = {1 - weights.sum(), weights[0], weights[1]};
    return std::ranges::all_of(narrowest.weights, [](double w) { return w >= 0; }) ? std::optional(narrowest)
                                                                                   : std::nullopt;
}

// A point of the curve next to another point, from a parameter not far off.
Vec3 point_near(const RationalCurve3& curve, double t, const Vec3& other) {
    constexpr int steps = 8;
    for (int n = 0; n < steps; ++n) {
        const auto [p, d] = curve.evaluate_with_derivative(t);
        if (const double step = (other - p).dot(d) / d.squaredNorm(); std::isfinite(step))
            t = std::clamp(t + step, curve.domain_begin(), curve.domain_end());
    }
    return curve.evaluate(t);
}

// Bounds on the least clearance along an arc that comes as near as `off` to the narrowest place, coordinates
// being no larger than `size`.
Interval least_through(const NarrowPlace& narrowest, const RationalCurve3& curve, double off, double size) {
    constexpr double few_roundings = 128 * std::numeric_limits<double>::epsilon();
    double farthest = off, bend = 0, slope = narrowest.slope() + few_roundings;
    for (const Eigen::Vector4d& c : curve.points)
        farthest = std::max(farthest, (c.head<3>() - narrowest.point).norm() + off);
    for (std::size_t i = 0; i < 3; ++i) {
        const double arm = narrowest.distances[i].arm;
        slope += few_roundings * size / arm;
        if (arm < infinity) bend += arm > off ? narrowest.weights[i] / (arm - off) : infinity;
    }
    const double c = narrowest.clearance(), rounding = few_roundings * size;
    return {c - slope * farthest - rounding, c + slope * off + 0.5 * bend * off * off + rounding};
}

}  // namespace

Extremes united(const Extremes& a, const Extremes& b) {
    return {
        {std::min(a.least.lower(), b.least.lower()), std::min(a.least.upper(), b.least.upper())},
        {std::max(a.greatest.lower(), b.greatest.lower()), std::max(a.greatest.upper(), b.greatest.upper())}};
}

Extremes clearance_along(const std::array<const Object*, 3>& objects, const RationalCurve3& curve,
                         double error) {
    double size = size_of(curve);
    for (const Object* object : objects) size = std::max(size, place_of(*object).cwiseAbs().sum());
    const double off = error + rounding_of(size);
    const DistanceAlong distance(*objects[0]);
    auto [range, least] = extremes_along(curve, off, distance);
    if (const std::optional<NarrowPlace> narrowest = narrow_place_near(objects, curve.evaluate(least))) {
        const Vec3 near = point_near(curve, least, narrowest->point);
        const Interval through =
            least_through(*narrowest, curve, (narrowest->point - near).norm() + off, size);
        range.least = Interval(std::max(range.least.lower(), through.lower()),
                               std::min(range.least.upper(), through.upper()));
    }
    return range;
}

Extremes height_along(const Vec3& origin, const Vec3& direction, const RationalCurve3& curve, double error) {
    const double off = error + rounding_of(std::max(size_of(curve), origin.cwiseAbs().sum()));
    return extremes_along(curve, off,
                          [&](const RationalCurve3& span) {
                              Range range;
                              for (const Eigen::Vector4d& c : span.points)
                                  range.extend(direction.dot(c.head<3>() - origin));
                              return range;
                          })
        .values;
}

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
