#include "circular_edges.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vcell {

using Eigen::Vector2d;

namespace {

using roundoff::u;

// What bounds a height's slope next to the edge, and the magnitudes that enter.
struct Height {
    const CircularForm& f;
    double bend = 2 * std::abs(f.k) / f.w, over_w = 1 / f.w, slope2 = 0, size = 0;

    explicit Height(const CircularForm& form) : f(form) {}
    void add(const Vector2d& p, double reach) {
        const double d = (p - Vector2d(f.cx, f.cy)).norm();
        const double linear = (std::abs(f.a * p.x()) + std::abs(f.b * p.y()) + std::abs(f.e)) * over_w;
        slope2 = std::max(slope2, gradient(f, p).squaredNorm());
        size = std::max(size, bend * d * (d + reach) + linear);
    }
    double slope(double off) const { return std::sqrt(slope2) + bend * off; }
};

}  // namespace

// [HE, Lemmas 1-3] over a plane base, by exact facts only. In the chart the curve is a line or a circle;
// lifted to a linear height it lies in that plane, lifted to two paraboloids in the plane that a
// linear combination of the two leaves.
CurveKind CircularEdges::kind(EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const CircularForm& f = diagram_.forms[edge.left];
    if (edge.on_rim()) return f.k == 0 ? CurveKind::Line : CurveKind::Parabola;
    const CircularForm& g = diagram_.forms[edge.right];
    if (f.k == 0 && g.k == 0) return CurveKind::Line;
    // A vertical plane through a paraboloid with vertical axis.
    if (arcs_.is_line(e)) return CurveKind::Parabola;
    // A vertical circular cylinder cut by the plane: a circle exactly when that plane is horizontal. For
    // two spheres it has the slope 2 (c_g - c_f) / (w_f - w_g). Coefficients here are zero in double
    // exactly when they are zero, and centres are exact up to rounding.
    const auto close = [](double a, double b) {
        return std::abs(a - b) <= 16 * u * (std::abs(a) + std::abs(b) + 1);
    };
    const bool horizontal = f.k != 0 && g.k != 0 ? close(f.cx, g.cx) && close(f.cy, g.cy) &&
                                                       of_.problem.on_one_normal(edge.left, edge.right)
                            : f.k == 0 ? f.a == 0 && f.b == 0
                                       : g.a == 0 && g.b == 0;
    return horizontal ? CurveKind::Circle : CurveKind::Ellipse;
}

int CircularEdges::degree(EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const bool curved =
        diagram_.forms[edge.left].k != 0 || (!edge.on_rim() && diagram_.forms[edge.right].k != 0);
    return curved ? 2 : 1;
}

void CircularEdges::set_trim(EdgeId e, bool reversed, RationalCurve2& curve) const {
    const std::span<const ArcSpan> spans = arcs_.spans(e);
    const int n = degree(e);
    begin_joined(curve, n, spans.size());
    const auto add = [&](const Vector2d& p, double w) { curve.points.push_back({p.x(), p.y(), w}); };
    add(spans.front().from, 1);
    for (const ArcSpan& span : spans) {
        if (n == 2) add(span.middle(), span.weight());
        add(span.to, 1);
    }
    // Knots are uniform and weights symmetric within each span: only the order changes.
    if (reversed) std::reverse(curve.points.begin(), curve.points.end());
}

// Along the edge's circle f is linear up to a multiple of the circle's equation, along a line it is
// quadratic; either way the control point where two tangents meet lies on the lifted curve's tangent,
// and its height is f(from) + grad f(from) . (middle - from). That needs neither centre nor radius.
void CircularEdges::set_curve(EdgeId e, RationalCurve3& curve, Range& heights) const {
    const std::span<const ArcSpan> spans = arcs_.spans(e);
    const int n = degree(e);
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    // A linear height is the better conditioned of the two.
    const bool use_right = !edge.on_rim() && diagram_.forms[edge.right].k == 0;
    const CircularForm& f = diagram_.forms[use_right ? edge.right : edge.left];
    const VertexId start = diagram_.start(e), end = diagram_.end(e);
    const auto height = [&](const Vector2d& p) { return f(p.x(), p.y()); };

    begin_joined(curve, n, spans.size());
    const auto add = [&](const Vector2d& p, double z, double w) {
        const Vec3 world = of_.problem.frame.to_world({p.x(), p.y(), z});
        curve.points.push_back({world.x(), world.y(), world.z(), w});
    };
    double z = start.valid() ? diagram_.vertices[start].height : height(spans.front().from);
    const double z_end = end.valid() ? diagram_.vertices[end].height : z;
    add(spans.front().from, z, 1);
    for (std::size_t i = 0; i < spans.size(); ++i) {
        const ArcSpan& span = spans[i];
        const double z_to = i + 1 == spans.size() ? z_end : height(span.to);
        double z_middle = z;
        if (n == 2) {
            const Vector2d m = span.middle();
            z_middle = 0.5 * (height(span.from) + gradient(f, span.from).dot(m - span.from)) +
                       0.5 * (height(span.to) + gradient(f, span.to).dot(m - span.to));
            add(m, z_middle, span.weight());
        }
        extend(heights, z, z_middle, z_to, span.weight());
        add(span.to, z_to, 1);
        z = z_to;
    }
}

// From the chart to space. The lifted curve has the heights of f over its chart curve, but for those of
// the vertices at its ends and rounding (r). Over the true arc, within `off` of the chart curve, both
// heights agree, so that one slope carries over; at the chart curve itself they differ by no more than
// both do.
double CircularEdges::error(EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    if (degree(e) == 1) return line_error(e);
    const double off = arcs_.error(e);
    Height left{diagram_.forms[edge.left]}, right{diagram_.forms[edge.on_rim() ? edge.left : edge.right]};
    for (const ArcSpan& span : arcs_.spans(e))
        for (const Vector2d& p : {span.from, span.middle(), span.to}) {
            const double reach = p.norm();
            left.add(p, reach);
            if (!edge.on_rim()) right.add(p, reach);
        }
    const double left_slope = left.slope(off), right_slope = edge.on_rim() ? 0 : right.slope(off);
    double r = 0;
    for (const VertexId v : {diagram_.start(e), diagram_.end(e)}) {
        if (!v.valid()) continue;
        const MinimizationDiagram::Vertex& at = diagram_.vertices[v];
        r = std::max(r, at.height_error + std::max(left_slope, right_slope) * at.error);
    }
    r += 16 * u * std::max(left.size, right.size);
    const double apart = r + (left_slope + right_slope) * off;
    return std::sqrt(off * off + apart * apart);
}

// A segment is as far from the true one as its ends are, and a linear height as far from it as at these,
// however steep it is: along a steep side of the box ends may be known less well than across it.
double CircularEdges::line_error(EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    double error = 0;
    for (const VertexId v : {diagram_.start(e), diagram_.end(e)}) {
        const MinimizationDiagram::Vertex& at = diagram_.vertices[v];
        error = std::max(error, std::hypot(at.error, at.height_error));
        for (const FormId f : {edge.left, edge.on_rim() ? edge.left : edge.right}) {
            Height height(diagram_.forms[f]);
            height.add(at.point, at.point.norm());
            const double beyond = std::abs(diagram_.forms[f](at.point.x(), at.point.y()) - at.height);
            error = std::max(error, beyond + 16 * u * height.size);
        }
    }
    return error;
}

}  // namespace vcell
