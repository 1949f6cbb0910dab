/// Arcs of trisectors over every base traced by bisection in the chart and polished in 200 bits, and how
/// far splines are from them.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/eigen.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "../../envelope/lift/cylinder_patch.hpp"
#include "../../envelope/lift/space_spline.hpp"
#include "test_support.hpp"

namespace vcell::traced_arcs {

using std::numbers::pi;

using Real = boost::multiprecision::number<
    boost::multiprecision::cpp_bin_float<200, boost::multiprecision::digit_base_2>,
    boost::multiprecision::et_off>;
template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using V4 = Eigen::Matrix<T, 4, 1>;

enum class Base { Plane, Sphere, Cylinder };

struct Case {
    BaseChart chart;
    std::array<SpaceSite, 2> sites;

    bool closes_up() const { return chart.is_cylinder(); }
};

inline SpaceFitError fitted(const BaseChart& chart, const SpaceArc& arc, double tolerance,
                            std::vector<SpaceSpan>& spans, FitEffort effort = {}) {
    return fit_space_spline(chart, arc, tolerance, spans, effort);
}
inline SpaceFitError fitted(const Case& c, const SpaceArc& arc, double tolerance,
                            std::vector<SpaceSpan>& spans) {
    return fitted(c.chart, arc, tolerance, spans);
}

/// Distances by their definitions; a wall's is signed, positive inside.
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
T distance_from_base(const Case& c, const V3<T>& p) {
    using std::sqrt;
    if (c.chart.is_plane()) return p.z();
    return c.chart.is_sphere() ? p.norm() : T(sqrt(p.x() * p.x() + p.z() * p.z()));
}

/// Zero on the bisector; along a ray from the base it decreases.
template <class T>
T excess(const Case& c, int side, const V3<T>& p) {
    const T d = distance_to(c.sites[side], p);
    return c.sites[side].is_wall ? d : T(d - distance_from_base(c, p) + T(c.chart.radius));
}

inline Vec3 normal_of(const Case& c, const Vec2& q) {
    return c.chart.is_plane() ? Vec3::UnitZ() : c.chart.normal(q);
}
inline Vec3 foot_of(const Case& c, const Vec2& q) {
    return {c.chart.is_plane() ? q.x() : 0, c.chart.is_plane() || c.closes_up() ? q.y() : 0, 0};
}

constexpr double far = 30;  // of the scene's unit: heights beyond are not traced

/// Height of a side over a chart point, by bisection.
inline double height(const Case& c, int side, const Vec2& q, double unit) {
    const Vec3 u = normal_of(c, q), f = foot_of(c, q);
    double low = 0, high = far * unit;
    if (excess<double>(c, side, f + high * u) > 0) return high;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (excess<double>(c, side, f + middle * u) > 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// Chart units: y is a length over a cylinder, x too over a plane, so steps in them scale with the scene.
struct ScaledChart {
    const Case& c;
    double unit;

    Vec2 scale() const {
        return {c.chart.is_plane() ? unit : 1, c.chart.is_plane() || c.closes_up() ? unit : 1};
    }
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
        if (c.closes_up()) s.x() -= 4 * std::floor((s.x() + 1) / 4);
        return s;
    }
};

struct Traced {
    std::vector<Vec2> line;  // scaled chart points, continuous around the cylinder
    bool closed = false;
    std::vector<MinimizationDiagram::ArcPiece> pieces;
    SpaceArc arc;
};

/// Newton's method in 200 bits, with the Jacobian of the start in double: equations(X) for V<Real> and
/// V<double>.
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

/// The point where base and sites agree in the slice through the start across `normal`.
inline V4<Real> polished(const Case& c, const Eigen::Vector4d& start, const Eigen::Vector4d& normal) {
    return solved<4>(
        [&]<class T>(const V4<T>& X) {
            const V3<T> p = X.template head<3>();
            V4<T> G;
            G[0] = distance_from_base(c, p) - X[3];
            for (int k = 0; k < 2; ++k) {
                const T d = distance_to(c.sites[k], p);
                G[k + 1] = c.sites[k].is_wall ? d : T(d - X[3] + T(c.chart.radius));
            }
            G[3] = normal.cast<T>().dot(V4<T>(X - start.cast<T>()));
            return G;
        },
        start);
}

inline Vec3 space_point(const Case& c, const ScaledChart& chart, const Vec2& s,
                        const Eigen::Vector4d& tangent) {
    const Vec2 q = chart.point(s);
    const double t = height(c, 0, q, chart.unit);
    Eigen::Vector4d X;
    X << foot_of(c, q) + t * normal_of(c, q), t;
    return polished(c, X, tangent).head<3>().cast<double>();
}

/// An arc of the trisector, the left site lower on the left; nothing where heights get large or the walk gets
/// nowhere.
inline std::optional<Traced> trace(const Case& c, double unit, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> side(-1, 1);
    const ScaledChart chart{c, unit};
    Vec2 a, b;
    bool found = false;
    for (int i = 0; i < 40 && !found; ++i) {
        a = {side(rng), side(rng)};
        b = {side(rng), side(rng)};
        if (c.closes_up()) {
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
            (Vec2(std::remainder(s.x() - a.x(), c.closes_up() ? 4.0 : 1e9), s.y() - a.y())).norm() < step) {
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
        // Between its points the arc turns by less than what the trace allows.
        const Vec2 bulge = Vec2::Constant(0.25 * step);
        low -= bulge;
        high += bulge;
        const Vec2 slope = chart.slope(result.line[(from + to) / 2]);
        piece.direction = slope.cwiseProduct(chart.scale()).normalized();
        piece.end = chart.wrapped(result.line[to]).cwiseProduct(chart.scale());
        piece.error = 1e-12 * std::min(1.0, unit);
        const Vec2 scale = chart.scale();
        piece.box = {(low.x() + shift) * scale.x(), (high.x() + shift) * scale.x(), low.y() * scale.y(),
                     high.y() * scale.y()};
        result.pieces.push_back(piece);
    };
    if (result.closed) result.line.back() = result.line.front();
    for (std::size_t i = 0; i + 1 < result.line.size(); i += stride)
        add_piece(i, std::min(i + stride, result.line.size() - 1));
    return result;
}

inline Vec3 random_unit(std::mt19937_64& rng) {
    std::normal_distribution<double> normal;
    return Vec3(normal(rng), normal(rng), normal(rng)).normalized();
}

/// A site that stays clear of the base: at random, of one of four kinds.
enum class Kind { Sphere, Cylinder, Plane, Wall };

inline SpaceSite random_site_over_plane(Kind kind, double unit, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> unit_range(0, 1), side(-1, 1);
    const double rho = 0.6 * unit_range(rng) * unit, gap = (0.3 + 2 * unit_range(rng)) * unit;
    const Vec3 above(side(rng) * unit, side(rng) * unit, rho + gap);
    const Vec3 level(side(rng), side(rng), 0);
    if (kind == Kind::Sphere) return {Sphere{above, rho}, false, {}};
    // Leaning by so little that it meets the base beyond all that is traced.
    if (kind == Kind::Cylinder)
        return {Cylinder{above, level.normalized() + 0.02 * side(rng) * Vec3::UnitZ(), rho}, false, {}};
    return {Plane{above, Vec3::UnitZ() + 0.02 * level}, kind == Kind::Wall, {}};
}

inline SpaceSite random_site(Kind kind, Base base, double radius, double unit, std::mt19937_64& rng) {
    if (base == Base::Plane) return random_site_over_plane(kind, unit, rng);
    const bool sphere_base = base == Base::Sphere;
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

/// `middle`: a normal or, over a plane, a foot point.
inline PatchCoordinates coordinates(const Case& c, int side, const Vec3& middle) {
    const SpaceSite& site = c.sites[side];
    const Cylinder* cylinder = std::get_if<Cylinder>(&site.object);
    if (c.chart.is_plane()) {
        if (!cylinder)
            return {PatchCoordinate::linear(Vec3::UnitX(), middle),
                    PatchCoordinate::linear(Vec3::UnitY(), middle)};
        const Vec3 &p = cylinder->point, &a = cylinder->axis;
        return CylinderFrame({p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), cylinder->radius}, middle.head<2>())
            .coordinates();
    }
    if (const Plane* plane = std::get_if<Plane>(&site.object);
        plane && (site.is_wall || c.chart.is_sphere())) {
        const Vec3 a = plane->normal.unitOrthogonal();
        return {PatchCoordinate::linear(a, plane->point),
                PatchCoordinate::linear(plane->normal.cross(a), plane->point)};
    }
    if (!c.chart.is_sphere()) {
        const Vec3 zero = Vec3(middle.x(), 0, middle.z()).normalized();
        Vec3 v = Vec3::UnitY();
        if (cylinder) v += (cylinder->axis.y() < 0 ? -1 : 1) * cylinder->axis.normalized();
        return {PatchCoordinate::half_angle(Vec3::Zero(), zero, Vec3::UnitY().cross(zero), 0),
                PatchCoordinate::linear(v, Vec3::Zero())};
    }
    if (cylinder) {
        const Vec3 d = cylinder->axis.normalized();
        const Vec3 foot = cylinder->point - d.dot(cylinder->point) * d, zero = -foot.normalized();
        return {PatchCoordinate::half_angle(foot, zero, d.cross(zero), cylinder->radius - c.chart.radius),
                PatchCoordinate::linear(d, foot)};
    }
    const Vec3 zero = std::get<Sphere>(site.object).center.normalized(), x = zero.unitOrthogonal();
    return {PatchCoordinate::half_angle(Vec3::Zero(), zero, x, 0),
            PatchCoordinate::half_angle(Vec3::Zero(), zero, zero.cross(x), 0)};
}

inline Case random_case(Base base, Kind left, Kind right, double unit, std::mt19937_64& rng) {
    const bool sphere_base = base == Base::Sphere;
    Case c;
    c.chart = {base == Base::Plane    ? BaseShape::Plane
               : base == Base::Sphere ? BaseShape::Sphere
                                      : BaseShape::Cylinder};
    c.chart.radius = c.chart.is_plane() ? 0 : std::uniform_real_distribution<double>(0, 1)(rng) * unit;
    const Vec3 about = sphere_base ? random_unit(rng) : Vec3::UnitY().eval();
    c.chart.turn =
        Eigen::AngleAxisd(std::uniform_real_distribution<double>(-pi, pi)(rng), about).toRotationMatrix();
    c.sites = {random_site(left, base, c.chart.radius, unit, rng),
               random_site(right, base, c.chart.radius, unit, rng)};
    return c;
}

/// A traced arc as an edge. Trims only where one patch holds the arc.
inline void make_arc(Traced& traced, Case& c, double unit) {
    const ScaledChart chart{c, unit};
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
    const Vec2 half_way = chart.point(traced.line[traced.line.size() / 2]);
    const Vec3 middle = c.chart.is_plane() ? foot_of(c, half_way) : normal_of(c, half_way);
    bool one_patch = true;
    for (const Vec2& s : traced.line)
        one_patch = one_patch && (c.chart.is_plane() || normal_of(c, chart.point(s)).dot(middle) > -0.7);
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
inline Eigen::Vector4d at(const SpaceSpan& span, double s) {
    return casteljau<4>(span.points.topRows<4>(), s);
}

template <class T>
T value(const PatchCoordinate& f, const V3<T>& p, const T& t) {
    V4<T> X;
    X << p, t;
    const V4<T> n = f.numerator.head<4>().cast<T>(), d = f.divisor.head<4>().cast<T>();
    return (n.dot(X) + T(f.numerator[4])) / (d.dot(X) + T(f.divisor[4]));
}

/// The patch's point at (u, v), near p. The parameters are scaled to lengths.
inline V3<Real> surface_point(const Case& c, int side, std::uint32_t which, const Vec2& uv,
                              const Vec3& near) {
    return solved<3>(
        [&]<class T>(const V3<T>& p) {
            const T t = distance_from_base(c, p), unit(near.norm());
            const PatchCoordinates& f = c.sites[side].parts[which].patch;
            return V3<T>(excess(c, side, p), (value(f[0], p, t) - T(uv[0])) * unit,
                         (value(f[1], p, t) - T(uv[1])) * unit);
        },
        near);
}

/// Largest distances found, of the curve and of the trims.
inline SpaceFitError measured(const Case& c, const std::vector<SpaceSpan>& spans) {
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

/// How far the traced points are from the spans, and the other way round, in steps of the trace.
inline double gap_between(const Case& c, const Traced& traced, double unit,
                          const std::vector<SpaceSpan>& spans) {
    const ScaledChart chart{c, unit};
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

}  // namespace vcell::traced_arcs
