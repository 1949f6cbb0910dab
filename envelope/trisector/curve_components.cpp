#include "curve_components.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "../../core/numbers/small_systems.hpp"
#include "uncut_curves.hpp"

namespace vcell {

namespace {

// The points of a curve between its ends, in order.
std::vector<Vec3> points_along(const RationalCurve3& curve, int of_each_span) {
    std::vector<Vec3> points{curve.evaluate(curve.domain_begin())};
    for (std::size_t k = 0; k + 1 < curve.knots.size(); ++k)
        for (int i = 1; curve.knots[k] < curve.knots[k + 1] && i <= of_each_span; ++i)
            points.push_back(
                curve.evaluate(std::lerp(curve.knots[k], curve.knots[k + 1], i / double(of_each_span))));
    return points;
}

Vec3 conic_direction(const TrisectorComponent& c, const Vec3& p) {
    if (c.kind == TrisectorKind::Line) return c.direction;
    return c.plane.head<3>().cross((c.quadric * p.homogeneous()).head<3>()).normalized();
}
// May a point of the component be within `error` of p? Its numbers are rounded.
bool may_hold(const TrisectorComponent& c, const Vec3& p, double error) {
    constexpr double rounding = 0x1p-44;
    if (c.kind == TrisectorKind::Line) {
        const Vec3 m = p - c.point;
        return (m - m.dot(c.direction) * c.direction).norm() <=
               error + rounding * (m.norm() + p.norm() + c.point.norm());
    }
    const Eigen::Vector4d X = p.homogeneous();
    if (std::abs(c.plane.dot(X)) > error + rounding * c.plane.cwiseAbs().dot(X.cwiseAbs())) return false;
    const Eigen::Vector4d gradient = c.quadric * X;
    const double slope = 2 * gradient.head<3>().norm() + c.quadric.norm() * error;
    return std::abs(X.dot(gradient)) <=
           slope * error + rounding * X.cwiseAbs().dot(c.quadric.cwiseAbs() * X.cwiseAbs());
}
// The component's point near p.
Vec3 projected_on(const TrisectorComponent& c, Vec3 p) {
    if (c.kind == TrisectorKind::Line) return c.point + c.direction.dot(p - c.point) * c.direction;
    constexpr int steps = 4;  // of Newton's method, across the curve
    for (int i = 0; i < steps; ++i) {
        const Eigen::Vector4d X = p.homogeneous(), gradient = c.quadric * X;
        Eigen::Matrix<double, 2, 3> J;
        J << c.plane.head<3>().transpose(), 2 * gradient.head<3>().transpose();
        const Eigen::Vector2d value(c.plane.dot(X), X.dot(gradient));
        const Eigen::Vector2d part = solution(J * J.transpose(), value);
        if (!part.allFinite()) break;  // the plane touches the quadric at p
        p -= J.transpose() * part;
    }
    return p;
}

}  // namespace

const TrisectorComponent& CurveComponents::of(const RationalCurve3& curve, double error) const {
    constexpr int of_each_span = 4;
    std::vector<const TrisectorComponent*> left;
    const std::vector<Vec3> points = points_along(curve, of_each_span);
    for (const TrisectorComponent& c : all_.components)
        if (c.kind == TrisectorKind::Spline ||
            std::ranges::all_of(points, [&](const Vec3& p) { return may_hold(c, p, error); }))
            left.push_back(&c);
    // All of the components that are no conics have one degree.
    const bool is_told = left.size() == 1 || std::ranges::all_of(left, [](const auto* c) {
                             return c->kind == TrisectorKind::Spline;
                         });
    if (left.empty() || !is_told) fail_trisector("may be one of several curves", points[points.size() / 2]);
    return *left.front();
}

std::vector<RationalCurve3> CurveComponents::along(const TrisectorComponent& conic,
                                                   const RationalCurve3& curve, bool is_closed) {
    constexpr double least_cosine = 0.2;  // of the turn between two stations
    constexpr int of_each_span = 8;
    std::vector<Vec3> points = points_along(curve, of_each_span), stations;
    for (Vec3& p : points) p = projected_on(conic, p);
    if (is_closed) points.back() = points.front();
    stations.push_back(points.front());
    Vec3 from = conic_direction(conic, points.front());
    for (std::size_t i = 1; i + 1 < points.size() && conic.kind != TrisectorKind::Line; ++i) {
        const Vec3 to = conic_direction(conic, points[i + 1]);
        if (to.dot(from) * (points[i + 1] - points[i]).dot(to) * (points[i] - points[i - 1]).dot(from) > 0 &&
            std::abs(to.dot(from)) > least_cosine)
            continue;
        stations.push_back(points[i]);
        from = conic_direction(conic, points[i]);
    }
    stations.push_back(points.back());
    std::vector<RationalCurve3> arcs;
    for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
        auto arc = trisector_arc(conic, stations[i], stations[i + 1]);
        if (!arc) fail_trisector("is a conic of which doubles do not tell an arc", stations[i]);
        arcs.push_back(*std::move(arc));
    }
    return arcs;
}

}  // namespace vcell
