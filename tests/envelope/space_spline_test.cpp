// Splines in space against arcs traced by bisection in the chart and points polished in 200 bits.
#include "../../envelope/lift/space_spline.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/eigen.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../../core/curves/quintic_nodes.hpp"
#include "../../core/curves/scaled_bernstein.hpp"
#include "test_support.hpp"

using namespace vcell;
using std::numbers::pi;

namespace {

using Real = boost::multiprecision::number<
    boost::multiprecision::cpp_bin_float<200, boost::multiprecision::digit_base_2>,
    boost::multiprecision::et_off>;
template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using V4 = Eigen::Matrix<T, 4, 1>;

struct Case {
    RadialBaseProblem problem;
    std::array<SpaceSite, 2> sites;
};

// Distances by their definitions; a wall's is signed, positive inside.
SpaceFitError fitted(const RadialBaseProblem& problem, const SpaceArc& arc, double tolerance,
                     std::vector<SpaceSpan>& spans) {
    FitEffort effort;
    return fit_space_spline(problem, arc, tolerance, spans, effort);
}

template <class T>
T distance_to(const SpaceSite& site, const V3<T>& p) {
    using std::abs;
    using std::sqrt;
    if (const Sphere* s = std::get_if<Sphere>(&site.object))
        return (p - s->center.cast<T>()).norm() - T(s->radius);
    if (const Cylinder* c = std::get_if<Cylinder>(&site.object)) {
        const V3<T> axis = c->axis.cast<T>();
        return V3<T>((p - c->point.cast<T>()).cross(axis)).norm() / axis.norm() - T(c->radius);
    }
    const Plane& plane = std::get<Plane>(site.object);
    const V3<T> n = plane.normal.cast<T>();
    const T signed_distance = n.dot(p - plane.point.cast<T>()) / n.norm();
    return site.is_wall ? T(-signed_distance) : T(abs(signed_distance));
}
template <class T>
T distance_from_base(const RadialBaseProblem& problem, const V3<T>& p) {
    using std::sqrt;
    return problem.is_sphere ? p.norm() : T(sqrt(p.x() * p.x() + p.z() * p.z()));
}

// Zero on the bisector; along a ray from the base it decreases.
template <class T>
T excess(const Case& c, int side, const V3<T>& p) {
    const T d = distance_to(c.sites[side], p);
    return c.sites[side].is_wall ? d : T(d - distance_from_base(c.problem, p) + T(c.problem.radius));
}

Vec3 normal_of(const Case& c, const Vec2& q) { return c.problem.normal(q); }
Vec3 foot_of(const Case& c, const Vec2& q) { return {0, c.problem.is_sphere ? 0 : q.y(), 0}; }

constexpr double far = 30;  // of the scene's unit: heights beyond are not traced

// Height of a side over a chart point, by bisection.
double height(const Case& c, int side, const Vec2& q, double unit) {
    const Vec3 u = normal_of(c, q), f = foot_of(c, q);
    double low = 0, high = far * unit;
    if (excess<double>(c, side, f + high * u) > 0) return high;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (excess<double>(c, side, f + middle * u) > 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

// Chart units: y is a length over a cylinder, so steps in it scale with the scene.
struct Chart {
    const Case& c;
    double unit;

    Vec2 scale() const { return {1, c.problem.is_sphere ? 1 : unit}; }
    double difference(const Vec2& s) const {
        const Vec2 q = point(s);
        return (height(c, 0, q, unit) - height(c, 1, q, unit)) / unit;
    }
    Vec2 slope(const Vec2& s) const {
        constexpr double h = 1e-5;
        return {(difference(s + Vec2(h, 0)) - difference(s - Vec2(h, 0))) / (2 * h),
                (difference(s + Vec2(0, h)) - difference(s - Vec2(0, h))) / (2 * h)};
    }
    bool is_near(const Vec2& s) const { return height(c, 0, point(s), unit) < 0.5 * far * unit; }
    Vec2 point(const Vec2& s) const { return wrapped(s).cwiseProduct(scale()); }
    // Once around is 4.
    Vec2 wrapped(Vec2 s) const {
        if (!c.problem.is_sphere) s.x() -= 4 * std::floor((s.x() + 1) / 4);
        return s;
    }
};

struct Traced {
    std::vector<Vec2> line;  // scaled chart points, continuous around the cylinder
    bool closed = false;
    std::vector<MinimizationDiagram::ArcPiece> pieces;
    SpaceArc arc;
};

// Newton's method in 200 bits, with the Jacobian of the start in double: equations(X) for V<Real> and
// V<double>.
template <int N, class F>
Eigen::Matrix<Real, N, 1> solved(const F& equations, const Eigen::Matrix<double, N, 1>& start) {
    Eigen::Matrix<double, N, N> J;
    const double h = 1e-6 * start.norm();
    for (int k = 0; k < N; ++k) {
        const Eigen::Matrix<double, N, 1> e = h * Eigen::Matrix<double, N, 1>::Unit(k);
        J.col(k) = (equations(Eigen::Matrix<double, N, 1>(start + e)) -
                    equations(Eigen::Matrix<double, N, 1>(start - e))) /
                   (2 * h);
    }
    const Eigen::Matrix<double, N, N> inverse = J.inverse();
    Eigen::Matrix<Real, N, 1> X = start.template cast<Real>();
    for (int i = 0; i < 60; ++i) {
        const Eigen::Matrix<double, N, 1> step =
            inverse * Eigen::Matrix<double, N, 1>(equations(X).template cast<double>());
        X -= step.template cast<Real>();
        if (step.norm() <= 1e-24 * start.norm()) return X;
    }
    throw std::runtime_error("Newton's method does not converge");
}

// The point where base and sites agree in the slice through the start across `normal`.
V4<Real> polished(const Case& c, const Eigen::Vector4d& start, const Eigen::Vector4d& normal) {
    return solved<4>(
        [&]<class T>(const V4<T>& X) {
            const V3<T> p = X.template head<3>();
            V4<T> G;
            G[0] = distance_from_base(c.problem, p) - X[3];
            for (int k = 0; k < 2; ++k) {
                const T d = distance_to(c.sites[k], p);
                G[k + 1] = c.sites[k].is_wall ? d : T(d - X[3] + T(c.problem.radius));
            }
            G[3] = normal.cast<T>().dot(V4<T>(X - start.cast<T>()));
            return G;
        },
        start);
}

Vec3 space_point(const Case& c, const Chart& chart, const Vec2& s, const Eigen::Vector4d& tangent) {
    const Vec2 q = chart.point(s);
    const double t = height(c, 0, q, chart.unit);
    Eigen::Vector4d X;
    X << foot_of(c, q) + t * normal_of(c, q), t;
    return polished(c, X, tangent).head<3>().cast<double>();
}

// An arc of the trisector, the left site lower on the left; nothing where heights get large or the walk gets
// nowhere.
std::optional<Traced> trace(const Case& c, double unit, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> side(-1, 1);
    const Chart chart{c, unit};
    Vec2 a, b;
    bool found = false;
    for (int i = 0; i < 40 && !found; ++i) {
        a = {side(rng), side(rng)};
        b = {side(rng), side(rng)};
        if (!c.problem.is_sphere) {
            a.x() = 1 + 2 * a.x();
            b.x() = a.x() + 0.5 * b.x();
        }
        found = chart.is_near(a) && chart.is_near(b) && chart.difference(a) < 0 && chart.difference(b) > 0;
    }
    if (!found) return std::nullopt;
    for (int i = 0; i < 50; ++i) {
        const Vec2 middle = 0.5 * (a + b);
        (chart.difference(middle) < 0 ? a : b) = middle;
    }
    constexpr double step = 0.04;
    constexpr int most = 180;
    Traced result;
    result.line.push_back(a);
    while (result.line.size() < most) {
        Vec2 s = result.line.back(), slope = chart.slope(s).normalized();
        const Vec2 before = s;
        s += step * Vec2(-slope.y(), slope.x());
        for (int i = 0; i < 4; ++i) {
            const Vec2 g = chart.slope(s);
            s -= chart.difference(s) / g.squaredNorm() * g;
        }
        if (!chart.is_near(s) || std::abs(chart.difference(s)) > 1e-9 || s.norm() > 8) break;
        if (std::abs((s - before).norm() - step) > 0.2 * step || chart.slope(s).normalized().dot(slope) < 0.8)
            break;
        result.line.push_back(s);
        if (result.line.size() > 4 && chart.wrapped(s - a + Vec2(-1, 0)).x() >= -1 &&
            (Vec2(std::remainder(s.x() - a.x(), c.problem.is_sphere ? 1e9 : 4.0), s.y() - a.y())).norm() <
                step) {
            result.closed = true;
            break;
        }
    }
    if (result.line.size() < 6) return std::nullopt;
    constexpr std::size_t stride = 5;
    const auto add_piece = [&](std::size_t from, std::size_t to) {
        MinimizationDiagram::ArcPiece piece;
        // The piece lies on one side of x = 3 by shifts of its own.
        const double shift = chart.wrapped(result.line[from]).x() - result.line[from].x();
        Vec2 low = result.line[from], high = low;
        for (std::size_t i = from; i <= to; ++i) {
            low = low.cwiseMin(result.line[i]);
            high = high.cwiseMax(result.line[i]);
        }
        const Vec2 slope = chart.slope(result.line[(from + to) / 2]);
        piece.direction = slope.cwiseProduct(chart.scale()).normalized();
        piece.end = chart.wrapped(result.line[to]).cwiseProduct(chart.scale());
        piece.error = 1e-12 * std::min(1.0, unit);
        piece.box = {low.x() + shift, high.x() + shift, low.y() * chart.scale().y(),
                     high.y() * chart.scale().y()};
        result.pieces.push_back(piece);
    };
    if (result.closed) result.line.back() = result.line.front();
    for (std::size_t i = 0; i + 1 < result.line.size(); i += stride)
        add_piece(i, std::min(i + stride, result.line.size() - 1));
    return result;
}

Vec3 random_unit(std::mt19937_64& rng) {
    std::normal_distribution<double> normal;
    return Vec3(normal(rng), normal(rng), normal(rng)).normalized();
}

// A site that stays clear of the base: at random, of one of four kinds.
enum class Kind { Sphere, Cylinder, Plane, Wall };

SpaceSite random_site(Kind kind, bool sphere_base, double radius, double unit, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> unit_range(0, 1);
    const double rho = 0.6 * unit_range(rng) * unit, gap = (0.3 + 2 * unit_range(rng)) * unit;
    Vec3 out = random_unit(rng);
    if (!sphere_base) {
        out.y() = 0;
        out.normalize();
    }
    const Vec3 along = sphere_base ? Vec3::Zero().eval() : Vec3(0, (2 * unit_range(rng) - 1) * unit, 0);
    switch (kind) {
        case Kind::Sphere: return {Sphere{along + (radius + rho + gap) * out, rho}, false, {}};
        case Kind::Cylinder:
            return {Cylinder{along + (radius + rho + gap) * out, 3 * random_unit(rng).cross(out), rho},
                    false,
                    {}};
        default: break;
    }
    // Over a cylinder the planes are parallel to the axis or nearly so.
    if (!sphere_base) out.y() = 0.1 * unit_range(rng);
    return {Plane{(radius + gap) * out.normalized(), 2 * out}, kind == Kind::Wall, {}};
}

PatchCoordinates coordinates(const Case& c, int side, const Vec3& middle) {
    const SpaceSite& site = c.sites[side];
    const Cylinder* cylinder = std::get_if<Cylinder>(&site.object);
    if (const Plane* plane = std::get_if<Plane>(&site.object);
        plane && (site.is_wall || c.problem.is_sphere)) {
        const Vec3 a = plane->normal.unitOrthogonal();
        return {PatchCoordinate::linear(a, plane->point),
                PatchCoordinate::linear(plane->normal.cross(a), plane->point)};
    }
    if (!c.problem.is_sphere) {
        const Vec3 zero = Vec3(middle.x(), 0, middle.z()).normalized();
        Vec3 v = Vec3::UnitY();
        if (cylinder) v += (cylinder->axis.y() < 0 ? -1 : 1) * cylinder->axis.normalized();
        return {PatchCoordinate::half_angle(Vec3::Zero(), zero, Vec3::UnitY().cross(zero), 0),
                PatchCoordinate::linear(v, Vec3::Zero())};
    }
    if (cylinder) {
        const Vec3 d = cylinder->axis.normalized();
        const Vec3 foot = cylinder->point - d.dot(cylinder->point) * d, zero = -foot.normalized();
        return {PatchCoordinate::half_angle(foot, zero, d.cross(zero), cylinder->radius - c.problem.radius),
                PatchCoordinate::linear(d, foot)};
    }
    const Vec3 zero = std::get<Sphere>(site.object).center.normalized(), x = zero.unitOrthogonal();
    return {PatchCoordinate::half_angle(Vec3::Zero(), zero, x, 0),
            PatchCoordinate::half_angle(Vec3::Zero(), zero, zero.cross(x), 0)};
}

Case random_case(bool sphere_base, Kind left, Kind right, double unit, std::mt19937_64& rng) {
    Case c;
    c.problem.is_sphere = sphere_base;
    c.problem.radius = std::uniform_real_distribution<double>(0, 1)(rng) * unit;
    const Vec3 about = sphere_base ? random_unit(rng) : Vec3::UnitY().eval();
    c.problem.chart =
        Eigen::AngleAxisd(std::uniform_real_distribution<double>(-pi, pi)(rng), about).toRotationMatrix();
    c.sites = {random_site(left, sphere_base, c.problem.radius, unit, rng),
               random_site(right, sphere_base, c.problem.radius, unit, rng)};
    return c;
}

// A traced arc as an edge. Trims only where one patch holds the arc.
void make_arc(Traced& traced, Case& c, double unit) {
    const Chart chart{c, unit};
    const auto tangent = [&](std::size_t i) {
        const std::size_t j = std::min(i + 1, traced.line.size() - 1), k = j - 1;
        const auto lift = [&](const Vec2& s) -> Vec3 {
            const Vec2 q = chart.point(s);
            return foot_of(c, q) + height(c, 0, q, unit) * normal_of(c, q);
        };
        Eigen::Vector4d T;
        T << (lift(traced.line[j]) - lift(traced.line[k])).normalized(), 0;
        return T;
    };
    const auto end = [&](std::size_t i) -> SpaceEnd {
        const Vec3 p = space_point(c, chart, traced.line[i], tangent(i));
        return {p, 2e-16 * p.norm()};
    };
    const Vec3 middle = normal_of(c, chart.point(traced.line[traced.line.size() / 2]));
    bool one_patch = true;
    for (const Vec2& s : traced.line)
        one_patch = one_patch && normal_of(c, chart.point(s)).dot(middle) > -0.7;
    for (int side = 0; side < 2; ++side) {
        c.sites[side].parts.clear();
        if (one_patch) c.sites[side].parts = {{coordinates(c, side, middle)}};
    }
    traced.arc.sites = c.sites;
    if (!traced.closed) {
        traced.arc.start = end(0);
        traced.arc.end = end(traced.line.size() - 1);
    }
    traced.arc.pieces = traced.pieces;
}

template <int Rows>
Eigen::Matrix<double, Rows, 1> casteljau(Eigen::Matrix<double, Rows, 6> b, double s) {
    for (int n = 5; n > 0; --n)
        for (int i = 0; i < n; ++i) b.col(i) = (1 - s) * b.col(i) + s * b.col(i + 1);
    return b.col(0);
}
Eigen::Vector4d at(const SpaceSpan& span, double s) { return casteljau<4>(span.points.topRows<4>(), s); }

template <class T>
T value(const PatchCoordinate& f, const V3<T>& p, const T& t) {
    V4<T> X;
    X << p, t;
    const V4<T> n = f.numerator.head<4>().cast<T>(), d = f.divisor.head<4>().cast<T>();
    return (n.dot(X) + T(f.numerator[4])) / (d.dot(X) + T(f.divisor[4]));
}

// The patch's point at (u, v), near p. The parameters are scaled to lengths.
V3<Real> surface_point(const Case& c, int side, std::uint32_t which, const Vec2& uv, const Vec3& near) {
    return solved<3>(
        [&]<class T>(const V3<T>& p) {
            const T t = distance_from_base(c.problem, p), unit(near.norm());
            const PatchCoordinates& f = c.sites[side].parts[which].patch;
            return V3<T>(excess(c, side, p), (value(f[0], p, t) - T(uv[0])) * unit,
                         (value(f[1], p, t) - T(uv[1])) * unit);
        },
        near);
}

// Largest distances found, of the curve and of the trims.
SpaceFitError measured(const Case& c, const std::vector<SpaceSpan>& spans) {
    SpaceFitError worst;
    for (const SpaceSpan& span : spans) {
        for (const double s : {0.0, 0.13, 0.3, 0.5, 0.62, 0.85, 1.0}) {
            const double h = 1e-3, s0 = std::clamp(s, h, 1 - h);
            const Eigen::Vector4d X = at(span, s), T = (at(span, s0 + h) - at(span, s0 - h)).normalized();
            const double off = (polished(c, X, T) - X.cast<Real>()).norm().convert_to<double>();
            worst.curve = std::max(worst.curve, off);
            for (int side = 0; side < 2; ++side) {
                if (c.sites[side].parts.empty()) continue;
                const Vec2 uv = casteljau<2>(span.points.middleRows<2>(4 + 2 * side), s);
                const Vec3 p = X.head<3>();
                const double lifted = (surface_point(c, side, span.part[side], uv, p) - p.cast<Real>())
                                          .norm()
                                          .convert_to<double>();
                worst.trims = std::max(worst.trims, lifted);
            }
        }
    }
    return worst;
}

// How far the traced points are from the spans, and the other way round, in steps of the trace.
double gap_between(const Case& c, const Traced& traced, double unit, const std::vector<SpaceSpan>& spans) {
    const Chart chart{c, unit};
    std::vector<Vec3> a, b;
    for (const Vec2& s : traced.line) {
        const Vec2 q = chart.point(s);
        a.push_back(foot_of(c, q) + height(c, 0, q, unit) * normal_of(c, q));
    }
    for (const SpaceSpan& span : spans)
        for (int i = 0; i <= 24; ++i) b.push_back(at(span, i / 24.0).head<3>());
    const auto off = [](const std::vector<Vec3>& points, const std::vector<Vec3>& line) {
        double worst = 0;
        for (const Vec3& p : points) {
            double least = HUGE_VAL;
            for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                const Vec3 e = line[i + 1] - line[i];
                const double s =
                    e.squaredNorm() > 0 ? std::clamp(e.dot(p - line[i]) / e.squaredNorm(), 0.0, 1.0) : 0;
                least = std::min(least, (p - line[i] - s * e).norm());
            }
            worst = std::max(worst, least);
        }
        return worst;
    };
    double step = 0;
    for (std::size_t i = 0; i + 1 < a.size(); ++i) step = std::max(step, (a[i + 1] - a[i]).norm());
    return std::max(off(a, b), off(b, a)) / step;
}

constexpr std::array kinds{Kind::Sphere, Kind::Cylinder, Kind::Plane, Kind::Wall};

}  // namespace

TEST_CASE("space splines: lie within the stated bound of the true arc, whole, over every base") {
    std::mt19937_64 rng(test_seed());
    int arcs = 0, trimmed = 0;
    double sharpest = 0;  // of bounds: true distance over bound
    for (int round = 0; round < 3 * rounds(); ++round) {
        const double unit = std::array{1.0, 1e-6, 1e6}[round % 3];
        for (const bool sphere_base : {true, false}) {
            for (const Kind left : kinds) {
                for (const Kind right : kinds) {
                    if (sphere_base && left != Kind::Cylinder && right != Kind::Cylinder) continue;
                    Case c = random_case(sphere_base, left, right, unit, rng);
                    auto traced = trace(c, unit, rng);
                    if (!traced) continue;
                    make_arc(*traced, c, unit);
                    for (const double relative : {1e-4, 1e-7}) {
                        const double tolerance = relative * 10 * unit;
                        CAPTURE(round);
                        CAPTURE(sphere_base);
                        CAPTURE(static_cast<int>(left));
                        CAPTURE(static_cast<int>(right));
                        CAPTURE(relative);
                        std::vector<SpaceSpan> spans;
                        const SpaceFitError error = fitted(c.problem, traced->arc, tolerance, spans);
                        CHECK(error.curve <= tolerance);
                        CHECK(error.trims <= tolerance);
                        const SpaceFitError truth = measured(c, spans);
                        CHECK(truth.curve <= error.curve);
                        CHECK(truth.trims <= error.trims);
                        sharpest = std::max(sharpest, truth.curve / error.curve);
                        CHECK(gap_between(c, *traced, unit, spans) <= 0.25);
                    }
                    ++arcs;
                    trimmed += !c.sites[0].parts.empty();
                }
            }
        }
    }
    CHECK(sharpest > 0.3);
    CHECK(arcs > 25 * rounds());
    CHECK(trimmed > 12 * rounds());
}

namespace {

// A ball between a base cylinder and a parallel one: its face is bounded by one closed edge.
struct Island {
    Case c;
    Traced traced;

    explicit Island(std::mt19937_64& rng) {
        c.problem.is_sphere = false;
        c.problem.radius = 0.5;
        c.sites = {SpaceSite{Sphere{{0, 0, 2}, 0.3}, false, {}},
                   SpaceSite{Cylinder{{0, 0, 3}, Vec3::UnitY(), 0.5}, false, {}}};
        for (int i = 0; i < 100 && !traced.closed; ++i)
            if (const auto found = trace(c, 1, rng)) traced = *found;
        REQUIRE(traced.closed);
        make_arc(traced, c, 1);
        for (int side = 0; side < 2; ++side) c.sites[side].parts = {{coordinates(c, side, Vec3::UnitZ())}};
        traced.arc.sites = c.sites;
    }
    SpaceEnd end_of(std::size_t piece) const {
        const Vec2& q = traced.pieces[piece].end;
        Eigen::Vector4d X;
        const double t = height(c, 0, q, 1);
        X << foot_of(c, q) + t * normal_of(c, q), t;
        const Vec3 tangent = normal_of(c, q).cross(Vec3(0.3, 0.5, 0.7));
        Eigen::Vector4d slice;
        slice << tangent.normalized(), 0;
        const Vec3 p = polished(c, X, slice).head<3>().cast<double>();
        return {p, 1e-15};
    }
};

SpaceFitError fitted(const Case& c, const SpaceArc& arc, double tolerance) {
    std::vector<SpaceSpan> spans;
    return fitted(c.problem, arc, tolerance, spans);
}

}  // namespace

TEST_CASE("space splines: an arc that is not the edge is not proved") {
    std::mt19937_64 rng(test_seed());
    constexpr double tolerance = 1e-5;
    Island island(rng);
    SpaceArc arc = island.traced.arc;
    CHECK(fitted(island.c, arc, tolerance).curve <= tolerance);

    SUBCASE("sides exchanged") {
        std::swap(arc.sites[0], arc.sites[1]);
        CHECK(fitted(island.c, arc, tolerance).curve > tolerance);
    }
    SUBCASE("ends exchanged, away from the arc, or passed once before") {
        const std::size_t last = arc.pieces.size() / 3;
        auto pieces = island.traced.pieces;
        arc.start = island.end_of(pieces.size() - 1);
        arc.end = island.end_of(last);
        arc.pieces = std::span(pieces).first(last + 1);
        CHECK(fitted(island.c, arc, tolerance).curve <= tolerance);

        SpaceArc exchanged = arc;
        std::swap(exchanged.start, exchanged.end);
        CHECK(fitted(island.c, exchanged, tolerance).curve > tolerance);

        SpaceArc away = arc;
        away.end->point += 1e-3 * Vec3(1, -1, 1);
        CHECK(fitted(island.c, away, tolerance).curve > tolerance);

        auto twice = pieces;
        twice.insert(twice.end(), pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(last) + 1);
        SpaceArc passed = arc;
        passed.pieces = twice;
        CHECK(fitted(island.c, passed, tolerance).curve > tolerance);
    }
}

TEST_CASE("space splines: the comparison with the true arc sees a span that is off") {
    std::mt19937_64 rng(test_seed());
    const Island island(rng);
    std::vector<SpaceSpan> spans;
    const SpaceFitError error = fitted(island.c.problem, island.traced.arc, 1e-5, spans);
    for (const int row : {0, 1, 2, 3, 4, 7}) {
        std::vector<SpaceSpan> off = spans;
        off[off.size() / 2].points(row, 3) += 20 * std::max(error.curve, error.trims);
        const SpaceFitError truth = measured(island.c, off);
        CAPTURE(row);
        CHECK((truth.curve > error.curve || truth.trims > error.trims));
    }
}

TEST_CASE("space splines: rims, open and closed, and faces in several parts") {
    Case c;
    c.problem.is_sphere = false;
    c.problem.radius = 0.5;
    constexpr double tolerance = 1e-6;
    // On the axis beyond the end: seen all around.
    const Sphere ball{{0.1, 3, 0.2}, 2};
    for (const double end : {1.0, -1.0}) {
        const double y = 0.6;
        const Sphere mirrored{{ball.center.x(), end * ball.center.y(), ball.center.z()}, ball.radius};
        c.sites = {SpaceSite{mirrored, false, {}}, SpaceSite{Plane{{0, end * y, 0}, {0, end, 0}}, true, {}}};
        for (const double angle : {0.3, 2.4, 4.5}) {
            const Vec3 zero(std::sin(angle), 0, std::cos(angle));
            c.sites[0].parts.push_back(
                {{PatchCoordinate::half_angle(Vec3::Zero(), zero, Vec3::UnitY().cross(zero), 0),
                  PatchCoordinate::linear(Vec3::UnitY(), Vec3::Zero())},
                 {-std::tan(0.525), std::tan(0.525)}});
        }
        SpaceArc arc;
        arc.sites = c.sites;
        std::vector<SpaceSpan> spans;
        const SpaceFitError error = fitted(c.problem, arc, tolerance, spans);
        CHECK(error.curve <= tolerance);
        CHECK(error.trims <= tolerance);
        const SpaceFitError truth = measured(c, spans);
        CHECK(truth.curve <= error.curve);
        CHECK(truth.trims <= error.trims);
        // The region on the left: with growing angle at the lower end.
        const auto angle_of = [](const Eigen::Vector4d& X) { return std::atan2(X[0], X[2]); };
        double turn = 0;
        std::array<bool, 3> used{};
        for (const SpaceSpan& span : spans) {
            turn += std::remainder(angle_of(at(span, 1)) - angle_of(at(span, 0)), 2 * pi);
            CHECK(span.points.row(4).cwiseAbs().maxCoeff() <= std::tan(0.525) + 1e-12);
            used[span.part[0]] = true;
        }
        CHECK(turn == doctest::Approx(-end * 2 * pi));
        CHECK((used[0] && used[1] && used[2]));

        // A third of it, ends given.
        std::vector<SpaceSpan> third;
        arc.start = SpaceEnd{spans.front().points.col(0).head<3>(), 1e-15};
        arc.end = SpaceEnd{spans[spans.size() / 3].points.col(5).head<3>(), 1e-15};
        CHECK(fitted(c.problem, arc, tolerance, third).curve <= tolerance);
        CHECK(third.back().points.col(5).head<3>() == arc.end->point);
        CHECK(third.size() < spans.size());
        // Ends known worse than the tolerance: no reason to halve.
        arc.start->error = arc.end->error = 100 * tolerance;
        std::vector<SpaceSpan> rough;
        CHECK(fitted(c.problem, arc, tolerance, rough).curve <= 600 * tolerance);
        CHECK(rough.size() <= third.size());
    }
}

TEST_CASE("space splines: an arc that ends where its sites touch") {
    // Crossing cylinders of one radius: the trisector is two curves that cross at (0, 0, 1.5).
    Case c;
    c.problem.is_sphere = true;
    c.problem.radius = 0.5;
    c.sites = {SpaceSite{Cylinder{{0, 0, 3}, {0, 1, 0}, 0.5}, false, {}},
               SpaceSite{Cylinder{{0, 0, 3}, {1, 0, 0}, 0.5}, false, {}}};
    std::vector<MinimizationDiagram::ArcPiece> pieces;
    double before = 0;
    for (const double x : {1e-5, 0.05, 0.15, 0.25}) {
        pieces.push_back({{x, x}, 1e-16, Vec2(1, -1).normalized(), {before, x, before, x}});
        before = x;
    }
    const auto lifted = [&](double x) -> Vec3 { return height(c, 0, {x, x}, 1) * normal_of(c, {x, x}); };
    SpaceArc arc;
    arc.sites = c.sites;
    arc.pieces = pieces;
    arc.start = SpaceEnd{lifted(0), 1e-15};
    arc.end = SpaceEnd{lifted(0.25), 1e-15};
    const auto check = [&](const std::vector<SpaceSpan>& spans, const SpaceFitError& error,
                           double tolerance) {
        CHECK(error.curve <= tolerance);
        CHECK(at(spans.back(), 1).head<3>() == arc.end->point);
        for (const SpaceSpan& span : spans)
            for (const double s : {0.2, 0.5, 0.8}) {
                const Eigen::Vector4d X = at(span, s);
                CHECK(std::abs(X[0] - X[1]) <= error.curve);
                CHECK(std::abs(excess<double>(c, 0, X.head<3>())) <= 2 * error.curve);
            }
    };
    for (const double tolerance : {1e-3, 1e-4}) {
        std::vector<SpaceSpan> spans;
        const SpaceFitError error = fitted(c.problem, arc, tolerance, spans);
        check(spans, error, tolerance);
    }
    // In their plane the crossing is a point like any other.
    arc.sites_cross = true;
    const std::vector<MinimizationDiagram::ArcPiece> whole{
        {{0.25, 0.25}, 1e-16, pieces[0].direction, {0, 0.25, 0, 0.25}}};
    for (const auto& part : {pieces, whole})
        for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
            arc.pieces = part;
            std::vector<SpaceSpan> spans;
            const SpaceFitError error = fitted(c.problem, arc, tolerance, spans);
            check(spans, error, tolerance);
            CHECK(spans.size() <= 16);
        }
}

namespace {

// Fits all edges of a diagram that have pieces or lie on a rim; the number of them.
int fit_diagram(const RadialBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance) {
    int fitted_edges = 0;
    for (const EdgeId e : diagram.edges.ids()) {
        const MinimizationDiagram::Edge& edge = diagram.edges[e];
        const auto pieces = diagram.pieces(e);
        if (pieces.empty() && !edge.on_rim()) continue;
        Case c;
        c.problem = problem;
        const auto site = [&](FormId f) -> SpaceSite {
            return {problem.objects[f], problem.sites[f].front().kind == Site::Kind::BoxSide, {}};
        };
        c.sites[0] = site(edge.left);
        if (edge.on_rim()) {
            const double sign = edge.side == 0 ? -1 : 1;
            c.sites[1] = {Plane{{0, problem.stretch[edge.side == 0 ? 0 : 1], 0}, {0, sign, 0}}, true, {}};
        } else {
            c.sites[1] = site(edge.right);
        }
        const auto end = [&](VertexId v) -> std::optional<SpaceEnd> {
            if (!v.valid()) return std::nullopt;
            const auto& vertex = diagram.vertices[v];
            const double t = problem.distance(vertex.point, vertex.height);
            return SpaceEnd{problem.point(vertex.point, t), 1e-10};
        };
        const HalfEdgeId h{2 * e.value};
        SpaceArc arc{c.sites, end(diagram.dcel.origin(h)), end(diagram.dcel.target(h)), pieces};
        std::vector<SpaceSpan> spans;
        const SpaceFitError error = fitted(problem, arc, tolerance, spans);
        CAPTURE(e.value);
        CAPTURE(edge.on_rim());
        CHECK(error.curve <= tolerance);
        if (error.curve <= tolerance) CHECK(measured(c, spans).curve <= error.curve);
        ++fitted_edges;
    }
    return fitted_edges;
}

}  // namespace

TEST_CASE("space splines: all edges of cells of cylinders and spheres among skew cylinders") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> size(0.1, 0.5), gap(0.3, 1.5), along(-3, 3);
    for (const bool sphere_base : {true, false}) {
        Scene scene;
        scene.box = {{-6, -6, -6}, {6, 6, 6}};
        if (sphere_base)
            scene.base = Sphere{{0, 0, 0}, 0.5};
        else
            scene.base = Cylinder{{0, 0, 0}, {0, 1, 0}, 0.5};
        for (int i = 0; i < 10; ++i) {
            Vec3 out = random_unit(rng);
            if (!sphere_base) out = Vec3(out.x(), 0, out.z()).normalized();
            const double rho = size(rng);
            const Vec3 foot = (0.5 + rho + gap(rng)) * out + (sphere_base ? 0 : along(rng)) * Vec3::UnitY();
            if (i % 3 == 2)
                scene.objects.push_back(Sphere{foot, rho});
            else
                scene.objects.push_back(Cylinder{foot, random_unit(rng).cross(out), rho});
        }
        const RadialBaseProblem problem = radial_base_problem(scene);
        const MinimizationDiagram diagram =
            sphere_base ? lower_envelope_on_sphere(problem.family)
                        : lower_envelope_on_cylinder(problem.family, problem.stretch[0], problem.stretch[1]);
        for (const double tolerance : {1e-3, 1e-6}) CHECK(fit_diagram(problem, diagram, tolerance) > 10);
    }
}

TEST_CASE("patch coordinates: tangents of half angles, and lengths") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> angle(-3, 3), size(0.1, 3);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 axis = random_unit(rng), zero = axis.unitOrthogonal(), quarter = axis.cross(zero);
        const Vec3 point = size(rng) * random_unit(rng);
        const double phi = angle(rng), distance = size(rng), t = size(rng), length = angle(rng);
        Eigen::Vector4d X;
        X << point + distance * (std::cos(phi) * zero + std::sin(phi) * quarter) + length * axis, t;
        const double tangent = std::tan(phi / 2);
        CHECK(PatchCoordinate::half_angle(point, zero, quarter, distance - t)(X) ==
              doctest::Approx(tangent).epsilon(1e-9));
        CHECK(PatchCoordinate::linear(axis, point)(X) == doctest::Approx(length).epsilon(1e-12));
    }
}

namespace {

template <int N>
Bernstein<N> random_polynomial(std::mt19937_64& rng, double size) {
    std::uniform_real_distribution<double> coefficient(-size, size);
    return Bernstein<N>::from([&](int) { return coefficient(rng); });
}

template <int N>
double largest_sample(const Bernstein<N>& p) {
    double most = 0;
    for (double s = 0; s <= 1; s += 0x1p-7) {
        double value = 0;
        for (int k = 0; k <= N; ++k) value += p.scaled[k] * std::pow(s, k) * std::pow(1 - s, N - k);
        most = std::max(most, std::abs(value));
    }
    return most;
}

}  // namespace

TEST_CASE("bernstein: squares are products, and coefficients bound a polynomial") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 200; ++round) {
        const auto p = random_polynomial<5>(rng, 1);
        const Bernstein<10> squared = square(p), product = p * p;
        for (int k = 0; k <= 10; ++k)
            CHECK(squared.coefficient(k) == doctest::Approx(product.coefficient(k)).epsilon(1e-14));
        CHECK(largest_sample(p) <= p.largest() + 1e-15);
    }
}

TEST_CASE("quintic nodes: polynomials are bounded, closely if they all but vanish there") {
    std::mt19937_64 rng(test_seed());
    const QuinticNodes& nodes = QuinticNodes::get();
    CHECK(largest_sample(nodes.sextic) == doctest::Approx(1).epsilon(1e-3));
    for (int round = 0; round < 200; ++round) {
        const Bernstein<4> steady = random_polynomial<4>(rng, 0.1) + 1;
        const Bernstein<10> vanishing = nodes.sextic * steady + random_polynomial<10>(rng, 1e-4);
        const double sampled = largest_sample(vanishing);
        CHECK(nodes.largest(vanishing) >= sampled);
        CHECK(nodes.largest(vanishing) <= 1.2 * sampled);
        const auto other = random_polynomial<10>(rng, 1);
        CHECK(nodes.largest(other) >= largest_sample(other));
    }
}
