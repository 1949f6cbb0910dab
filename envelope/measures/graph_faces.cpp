// Measures of faces that are graphs over the plane of two skew axes.
#include <Eigen/Geometry>
#include <cmath>

#include "../../core/quadrature/quadrature.hpp"
#include "../lift/skew_axes.hpp"
#include "radial_integrals.hpp"
#include "radial_terms.hpp"

namespace vcell::radial_integrals {

GraphFace::GraphFace(const SkewFace& heights, const SkewAxes& axes, const Around& face)
    : rays(heights),
      x(axes.x),
      y(axes.y),
      z(axes.x.cross(axes.y)),
      foot(axes.origin),
      x0(axes.x0),
      y0(axes.y0),
      half_apart(0.5 * axes.apart),
      steep(axes.steep),
      bend(steep * x.y() * y.y()),
      near(x.dot(face.near - foot), y.dot(face.near - foot)) {
    constexpr double narrow = 0x1p-10, far = 4;  // matters of digits: all are right
    const Vec2 crossing = Vec2(x0, y0) + near;
    const double reach = std::hypot(face.near.x(), face.near.z());
    is_narrow = std::abs(along_normal(crossing)) < narrow * reach * element(crossing);
    is_far = crossing.norm() > far * face.extent;
}

std::optional<GraphFace> GraphFace::of(const RadialBaseProblem& problem, FormId form, const SkewFace& heights,
                                       const Around& face) {
    constexpr double most_steep = 0x1p10;  // a matter of digits, too
    const auto axes = SkewAxes::of(problem, form, face.near.y());
    if (!axes) return std::nullopt;
    const GraphFace graph(heights, *axes, face);
    const double reach = (Vec2(graph.x0, graph.y0) + graph.near).norm() + face.extent;
    return graph.steep * reach < most_steep ? std::optional(graph) : std::nullopt;
}

// A ray's point is on the graph, and so is the way there: n.(t du + dt u + dy e_y) = 0 for the normal n.
GraphFace::Point GraphFace::point(const Place& place) const {
    const SpanPoint<double>& p = place.curve;
    Vec3 q = Vec3(p.x, p.y, p.z) - foot, dq(p.x1, p.y1, p.z1);
    double condition = 1;
    if (!is_narrow) {
        const Vec3 u(place.ray.u[0], 0, place.ray.u[2]), du(place.ray.du[0], 0, place.ray.du[2]);
        const double t = rays.distance(place.ray);
        q = Vec3(t * u.x(), place.ray.y - foot.y(), t * u.z());
        const Vec3 n = z + steep * ((y0 + y.dot(q)) * x + (x0 + x.dot(q)) * y);
        const Vec3 beside(t * du.x(), p.y1, t * du.z());
        const double rise = n.dot(u);
        dq = beside - (n.dot(beside) / rise) * u;
        condition += n.norm() / std::abs(rise);
    }
    return {{x.dot(q), y.dot(q)}, {x.dot(dq), y.dot(dq)}, condition};
}

// With the base's direction (x_y, y_y) along x and y, what the way across its axis has along the normal is
//
//     h / 2 - k (X^2 + Y^2),   k = steep x_y y_y,
//
// of which the part of degree n about a point counts 1 / (n + 2) of the angle that is swept from there. The
// area element sqrt(1 + w), w = steep^2 (X^2 + Y^2), has an integral along rays from the crossing.
Share GraphFace::share(const Place& place) const {
    const auto [at, way, condition] = point(place);
    const Vec2 q = at - near, crossing = Vec2(x0, y0) + near;
    const double turn = q.x() * way.y() - q.y() * way.x();
    const double linear = -2 * bend * crossing.dot(q), square = -bend * q.squaredNorm();
    const double volume = 0.5 * (0.5 * along_normal(crossing) + linear / 3 + 0.25 * square) * turn;
    const Vec2 from_crossing = Vec2(x0, y0) + at;
    if (!is_far) {
        const double sweep = from_crossing.x() * way.y() - from_crossing.y() * way.x();
        return {volume, swept(steep * steep * from_crossing.squaredNorm()) * sweep};
    }
    // The element is singular three times as far away, in the complex plane, as the edge is: 8 points do.
    const quadrature::RuleOf<8>& rule = quadrature::rule<8>();
    double mean = 0;
    for (int i = 0; i < 4; ++i)
        for (const double s : {-rule.x[i], rule.x[i]}) {
            const double part = 0.5 + 0.5 * s;
            mean += 0.5 * rule.weight[i] * part * element(crossing + part * q);
        }
    return {volume, mean * turn};
}

// ((1 + w)^(3/2) - 1) / (3 w), where nothing cancels.
double GraphFace::swept(double w) {
    const double root = std::sqrt(1 + w);
    return (w + 2 + root) / (3 * (1 + root));
}

double GraphFace::along_normal(const Vec2& from_crossing) const {
    return half_apart - bend * from_crossing.squaredNorm();
}
double GraphFace::element(const Vec2& at) const { return std::sqrt(1 + steep * steep * at.squaredNorm()); }

Share GraphFace::size(const Place& place) const {
    const auto [at, way, condition] = point(place);
    const SpanPoint<double>& p = place.curve;
    const double rounding = noise * Vec3(p.x, p.y, p.z).norm(), reach = (at - near).norm() + rounding,
                 from_crossing = (Vec2(x0, y0) + at).norm(), farthest = from_crossing + 2 * reach;
    const double heights = half_apart + std::abs(bend) * farthest * farthest;
    const double speed = way.norm() * condition, highest = element(Vec2(from_crossing, 0));
    return {heights * reach * speed, highest * (is_far ? reach : from_crossing) * speed};
}

double GraphFace::gap(const SpanPoint<double>& p, const Ray& ray, double t) const {
    if (!is_narrow) return rays.distance(ray) - t;
    const Vec3 q = Vec3(p.x, p.y, p.z) - foot;
    const double X = x0 + x.dot(q), Y = y0 + y.dot(q);
    return (half_apart - steep * X * Y - z.dot(q)) / element({X, Y});
}

}  // namespace vcell::radial_integrals
