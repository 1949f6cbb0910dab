#include "sphere_arcs.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

#include "../diagram/chart_arc.hpp"
#include "conic_trim.hpp"

namespace vcell::radial {

using Eigen::Vector2d;
using Eigen::Vector4d;

namespace {

// The height is linear in (p, L, w), too: its negative.
double root(const CircularForm& f, const Vector2d& p, double L, double w) {
    return -(f.k * L + f.a * p.x() + f.b * p.y() + f.e * w) / f.w;
}

// The form that is evaluated with less cancellation.
const CircularForm& smaller(const CircularForm& f, const CircularForm& g) {
    const auto magnitude = [](const CircularForm& form) {
        return (std::abs(form.k) + std::abs(form.a) + std::abs(form.b) + std::abs(form.e)) / form.w;
    };
    return magnitude(g) < magnitude(f) ? g : f;
}

// The conic on which two forms agree, from arcs of its directions.
class SphereArc {
public:
    SphereArc(const RadialBaseProblem& problem, const std::array<const Hyperplane*, 2>& planes,
              std::vector<ConicSpan>& spans)
        : problem_(problem), planes_(planes), spans_(spans) {}

    // Between two vertices, from directions alone. Not where rounding could take a short arc for all but a
    // full circle.
    void add_between(const Vector4d& from, const Vector4d& to) {
        const Vec3 normal = planes_[0]->gradient() - planes_[1]->gradient();
        const double length = normal.norm(),
                     size = planes_[0]->gradient().norm() + planes_[1]->gradient().norm();
        const Vec3 u = from.head<3>() / from.w(), v = to.head<3>() / to.w();
        const double radius2 = 1 - std::pow(normal.dot(u) / length, 2);
        // Output accuracy: of normals, radii (of the unit sphere) and arcs (of their circle) that are smaller
        // parts rounding would be a part of a thousand times the last digits; heights tell such arcs better.
        constexpr double least_normal = 0x1p-10, least_radius2 = 0x1p-10, least_chord2 = 0x1p-20;
        if (!(length > least_normal * size && radius2 > least_radius2 &&
              (v - u).squaredNorm() > least_chord2 * radius2))
            return;
        add_about(normal / length, from, to);
    }

    // Along arcs of the chart, on f and another form. On a circle |p|^2 is a linear function of p plus a
    // constant, on a line it is quadratic. Either way its polar form, half the derivative along the tangent
    // in the arc's ends, is the coefficient of the middle control point m: p0.(2 m - p0) = p2.(2 m - p2).
    // Without vertices the edge is closed.
    void add_along(std::span<const ArcSpan> arcs, const CircularForm& f, const Vector4d* first,
                   const Vector4d* last) {
        const auto end_point = [&](const Vector2d& p) -> Vector4d {
            const double L = p.squaredNorm();
            return moved_on_cone(lifted(p, L, 1) / root(f, p, L, 1), planes_);
        };
        Vector4d from = first != nullptr ? *first : end_point(arcs.front().from);
        const Vector4d end = last != nullptr ? *last : from;
        for (std::size_t i = 0; i < arcs.size(); ++i) {
            const ArcSpan& arc = arcs[i];
            const Vector4d to = i + 1 == arcs.size() ? end : end_point(arc.to);
            const double w = arc.weight();
            const Vector2d m = arc.middle();
            const double L = 0.5 * w * (arc.from.dot(2 * m - arc.from) + arc.to.dot(2 * m - arc.to));
            // W / t = Q: that the weights at the ends become 1.
            const double scale =
                std::sqrt(from.w() / (1 + arc.from.squaredNorm()) * to.w() / (1 + arc.to.squaredNorm()));
            const double weight = scale * root(f, w * m, L, w);
            add_halves({from, moved(scale * lifted(w * m, L, w), weight, planes_), to, weight}, {}, spans_);
            from = to;
        }
    }

private:
    // (n, W) of a chart point with |p|^2 = L in homogeneous coordinates (p, L, w).
    Vector4d lifted(const Vector2d& p, double L, double w) const {
        const Vec3 n = problem_.chart.turn * Vec3(2 * p.x(), 2 * p.y(), w - L);
        return {n.x(), n.y(), n.z(), w + L};
    }

    // The part of the cone over the circle's arc counter-clockwise about the unit normal, as seen from
    // outside. With the half turn a that the arc makes about the circle's centre, the control points over its
    // ends and over the point where the tangents there meet have weights t0, sqrt(t0 t1) cos a and t1 in (u,
    // 1).
    void add_about(const Vec3& normal, const Vector4d& from, const Vector4d& to) {
        const Vec3 u = from.head<3>() / from.w(), v = to.head<3>() / to.w(), chord = v - u;
        const Vec3 center = normal.dot(u) * normal, middle = 0.5 * (u + v) - center;
        const double half2 = 0.25 * chord.squaredNorm(), depth2 = middle.squaredNorm(),
                     radius2 = half2 + depth2;
        const Hyperplane& plane = *planes_[planes_[0]->steepness() < planes_[1]->steepness() ? 0 : 1];
        const Vec3 right = chord.cross(normal);
        if (middle.dot(right) > 0 && depth2 > 0.5 * radius2) {
            const double w = std::sqrt(from.w() * to.w() * depth2 / radius2);
            Vector4d apex;
            apex << w * (0.5 * (u + v) + half2 / depth2 * middle), w;
            const double weight = plane.weight(apex);
            add_halves({from, moved(apex, weight, planes_), to, weight}, {}, spans_);
            return;
        }
        Vector4d half_way;
        half_way << center + std::sqrt(radius2) * right.normalized(), 1;
        half_way = moved_on_cone(half_way / plane.weight(half_way), planes_);
        add_about(normal, from, half_way);
        add_about(normal, half_way, to);
    }

    const RadialBaseProblem& problem_;
    const std::array<const Hyperplane*, 2> planes_;
    std::vector<ConicSpan>& spans_;
};

}  // namespace

Decisions add_sphere_arcs(const RadialDiagram& of, RadialCurves& curves, unsigned threads) {
    const MinimizationDiagram& diagram = of.diagram;
    const EdgeEquations& equations = curves.equations();
    const auto is_arc = [&](EdgeId e) {
        return !curves.is_line(e) && !curves.is_spline(e) && !curves.is_axial_conic(e);
    };
    curves.set_all_conics(threads, [&](EdgeId e, std::vector<ConicSpan>& spans) {
        if (is_arc(e) && curves.has_ends(e) && diagram.start(e) != diagram.end(e))
            SphereArc(of.problem, equations.hyperplanes(e), spans).add_between(curves.from(e), curves.to(e));
    });
    std::vector<EdgeId> in_chart;
    for (const EdgeId e : diagram.edges.ids())
        if (curves.conics(e).empty() && is_arc(e)) in_chart.push_back(e);
    if (in_chart.empty()) return {};
    const ChartArcs arcs(of.problem.family, diagram, in_chart);
    for (const EdgeId e : in_chart)
        curves.set_conics(e, [&](std::vector<ConicSpan>& spans) {
            const MinimizationDiagram::Edge& edge = diagram.edges[e];
            const Vector4d *from = nullptr, *to = nullptr;
            if (curves.has_ends(e)) {
                from = &curves.from(e);
                to = &curves.to(e);
            }
            SphereArc(of.problem, equations.hyperplanes(e), spans)
                .add_along(arcs.spans(e), smaller(diagram.forms[edge.left], diagram.forms[edge.right]), from,
                           to);
        });
    return arcs.decisions();
}

}  // namespace vcell::radial
