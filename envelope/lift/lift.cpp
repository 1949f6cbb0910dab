#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "../diagram/chart_arc.hpp"
#include "../measures/measures.hpp"
#include "joined_spans.hpp"
#include "mixed_arc.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

// Rounding of a patch's control points, in the magnitudes that enter them: some ten operations, and
// coefficients within 4 u.
constexpr double patch_rounding = 32 * u;

class Lifter {
public:
    Lifter(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance)
        : problem_(problem),
          diagram_(diagram),
          arcs_(problem.family, diagram),
          mixed_(problem, diagram, tolerance) {}

    LiftedCell lift(bool with_measures) {
        add_vertices();
        add_edges();
        add_faces();
        if (with_measures) {
            measure(problem_, diagram_, arcs_, mixed_, cell_);
            set_max_clearance();
        } else {
            rank_neighbors(cell_);
        }
        cell_.report.decisions = diagram_.decisions;
        cell_.report.decisions += arcs_.decisions();
        IdVector<EdgeId, double> positions;
        positions.reserve(cell_.edges.size());
        for (const CellEdge& e : cell_.edges) positions.push_back(e.error);
        return {std::move(cell_), std::move(positions)};
    }

private:
    void add_vertices() {
        cell_.vertices.reserve(diagram_.vertices.size());
        for (const VertexId v : diagram_.vertices.ids()) {
            const MinimizationDiagram::Vertex& from = diagram_.vertices[v];
            CellVertex vertex;
            const Vec3 canonical(from.point.x(), from.point.y(), from.height);
            vertex.point = problem_.frame.to_world(canonical);
            vertex.radius = std::max(0.0, from.height);
            for (const FormId f : diagram_.label(v))
                vertex.sites.insert(vertex.sites.end(), problem_.sites[f].begin(), problem_.sites[f].end());
            add_rim_sites(diagram_.sides(v), vertex.sites);
            sort_unique(vertex.sites);
            // The motion back: three products and three sums a coordinate, of factors rounded once.
            vertex.error = std::hypot(from.error, from.height_error) +
                           8 * u * (canonical.norm() + problem_.frame.origin.norm());
            cell_.vertices.push_back(std::move(vertex));
        }
    }

    // The sides of the box over which a vertex lies: at a corner of the region all that run through it.
    void add_rim_sites(std::span<const std::uint32_t> sides, SmallVector<Site, 4>& sites) const {
        for (const std::uint32_t side : sides) sites.push_back(problem_.region[side].site);
        if (sides.size() < 2) return;
        const std::size_t n = problem_.region.size();
        const std::size_t corner = sides[1] == (sides[0] + 1) % n ? sides[1] : sides[0];
        const auto& through = problem_.corner_sites[corner];
        sites.insert(sites.end(), through.begin(), through.end());
    }

    Site main_site(FormId f) const { return problem_.sites[f].front(); }

    // [HE, Lemmas 1-3] over a plane base, by exact facts only. In the chart the curve is a line or a circle;
    // lifted to a linear height it lies in that plane, lifted to two paraboloids in the plane that a
    // linear combination of the two leaves.
    CurveKind kind(EdgeId e) const {
        if (mixed_.contains(e)) return mixed_.kind(e);
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
                                                           problem_.on_one_normal(edge.left, edge.right)
                                : f.k == 0 ? f.a == 0 && f.b == 0
                                           : g.a == 0 && g.b == 0;
        return horizontal ? CurveKind::Circle : CurveKind::Ellipse;
    }

    // Chart control points (x, y, w) of an edge, in the direction of its loop.
    static RationalCurve2 trim_curve(std::span<const ArcSpan> spans, int degree, bool reversed) {
        RationalCurve2 curve;
        begin_joined(curve, degree, spans.size());
        const auto add = [&](const Vector2d& p, double w) { curve.points.push_back({p.x(), p.y(), w}); };
        add(spans.front().from, 1);
        for (const ArcSpan& span : spans) {
            if (degree == 2) add(span.middle(), span.weight());
            add(span.to, 1);
        }
        // Knots are uniform and weights symmetric within each span: only the order changes.
        if (reversed) std::reverse(curve.points.begin(), curve.points.end());
        return curve;
    }

    // The joined Bezier pieces of one degree: control(span, k) gives the k-th point of a piece.
    template <class Curve, class Control>
    static Curve joined(std::span<const MixedSpan> spans, int degree, Control control) {
        Curve curve;
        begin_joined(curve, degree, spans.size());
        curve.points.push_back(control(spans.front(), 0));
        for (const MixedSpan& span : spans)
            for (int k = 1; k <= degree; ++k) curve.points.push_back(control(span, k));
        return curve;
    }

    // The trim of an edge beside a cylinder, on its left (side 0) or right, in the direction of the loop.
    static RationalCurve2 mixed_trim(std::span<const MixedSpan> spans, int side) {
        const int degree = spans.front().trims[side].degree;
        RationalCurve2 curve =
            degree > 0
                ? joined<RationalCurve2>(spans, degree,
                                         [&](const MixedSpan& s, int k) { return s.trims[side].points[k]; })
                : joined<RationalCurve2>(spans, spans.front().degree, [](const MixedSpan& s, int k) {
                      const Eigen::Vector4d& p = s.points[k];
                      return Eigen::Vector3d(p.x(), p.y(), p.w());
                  });
        if (side == 1) std::reverse(curve.points.begin(), curve.points.end());
        return curve;
    }

    RationalCurve3 mixed_space_curve(std::span<const MixedSpan> spans, Range& heights) const {
        for (const MixedSpan& s : spans) {
            std::array<double, MixedSpan::largest_degree + 1> z;
            for (int k = 0; k <= s.degree; ++k) z[k] = s.points[k].z();
            if (s.degree == 2)
                extend(heights, z[0], z[1], z[2],
                       s.points[1].w() / std::sqrt(s.points[0].w() * s.points[2].w()));
            else
                extend_by_polynomial(heights, {z.data(), static_cast<std::size_t>(s.degree) + 1});
        }
        return joined<RationalCurve3>(spans, spans.front().degree, [&](const MixedSpan& s, int k) {
            const Eigen::Vector4d& p = s.points[k];
            const Vec3 world = problem_.frame.to_world(p.head<3>());
            return Eigen::Vector4d(world.x(), world.y(), world.z(), p.w());
        });
    }

    int degree(EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const bool curved =
            diagram_.forms[edge.left].k != 0 || (!edge.on_rim() && diagram_.forms[edge.right].k != 0);
        return curved ? 2 : 1;
    }

    // Along the edge's circle f is linear up to a multiple of the circle's equation, along a line it is
    // quadratic; either way the control point where two tangents meet lies on the lifted curve's tangent,
    // and its height is f(from) + grad f(from) . (middle - from). That needs neither centre nor radius.
    RationalCurve3 space_curve(EdgeId e, std::span<const ArcSpan> spans, int degree, Range& heights) const {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        // A linear height is the better conditioned of the two.
        const bool use_right = !edge.on_rim() && diagram_.forms[edge.right].k == 0;
        const CircularForm& f = diagram_.forms[use_right ? edge.right : edge.left];
        const VertexId start = diagram_.dcel.origin(Dcel::half_edge(e)),
                       end = diagram_.dcel.target(Dcel::half_edge(e));
        const auto height = [&](const Vector2d& p) { return f(p.x(), p.y()); };

        RationalCurve3 curve;
        begin_joined(curve, degree, spans.size());
        const auto add = [&](const Vector2d& p, double z, double w) {
            const Vec3 world = problem_.frame.to_world({p.x(), p.y(), z});
            curve.points.push_back({world.x(), world.y(), world.z(), w});
        };
        double z = start.valid() ? diagram_.vertices[start].height : height(spans.front().from);
        const double z_end = end.valid() ? diagram_.vertices[end].height : z;
        add(spans.front().from, z, 1);
        for (std::size_t i = 0; i < spans.size(); ++i) {
            const ArcSpan& span = spans[i];
            const double z_to = i + 1 == spans.size() ? z_end : height(span.to);
            double z_middle = z;
            if (degree == 2) {
                const Vector2d m = span.middle();
                z_middle = 0.5 * (height(span.from) + gradient(f, span.from).dot(m - span.from)) +
                           0.5 * (height(span.to) + gradient(f, span.to).dot(m - span.to));
                add(m, z_middle, span.weight());
            }
            extend(heights, z, z_middle, z_to, span.weight());
            add(span.to, z_to, 1);
            z = z_to;
        }
        return curve;
    }

    // The motion back, as for vertices: of all points at once.
    double motion_back(const RationalCurve3& curve) const {
        double square = 0;
        for (const Eigen::Vector4d& p : curve.points) square = std::max(square, p.head<3>().squaredNorm());
        return 8 * u * (std::sqrt(square) + problem_.frame.origin.norm());
    }

    // From the chart to space. The lifted curve has the heights of f over its chart curve, but for those of
    // the vertices at its ends and rounding (r). Over the true arc, within `off` of the chart curve, both
    // heights agree, so that one slope carries over; at the chart curve itself they differ by no more than
    // both do.
    double circular_edge_error(EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const double off = arcs_.error(e);
        // What bounds a height's slope next to the edge, and the magnitudes that enter.
        struct Height {
            const CircularForm& f;
            double bend = 2 * std::abs(f.k) / f.w, over_w = 1 / f.w, slope2 = 0, size = 0;

            void add(const Vector2d& p, double reach) {
                const double d = (p - Vector2d(f.cx, f.cy)).norm();
                const double linear =
                    (std::abs(f.a * p.x()) + std::abs(f.b * p.y()) + std::abs(f.e)) * over_w;
                slope2 = std::max(slope2, gradient(f, p).squaredNorm());
                size = std::max(size, bend * d * (d + reach) + linear);
            }
            double slope(double off) const { return std::sqrt(slope2) + bend * off; }
        };
        Height left{diagram_.forms[edge.left]}, right{diagram_.forms[edge.on_rim() ? edge.left : edge.right]};
        for (const ArcSpan& span : arcs_.spans(e))
            for (const Vector2d& p : {span.from, span.middle(), span.to}) {
                const double reach = p.norm();
                left.add(p, reach);
                if (!edge.on_rim()) right.add(p, reach);
            }
        const double left_slope = left.slope(off), right_slope = edge.on_rim() ? 0 : right.slope(off);
        double r = 0;
        for (const VertexId v :
             {diagram_.dcel.origin(Dcel::half_edge(e)), diagram_.dcel.target(Dcel::half_edge(e))}) {
            if (!v.valid()) continue;
            const MinimizationDiagram::Vertex& at = diagram_.vertices[v];
            r = std::max(r, at.height_error + std::max(left_slope, right_slope) * at.error);
        }
        r += 16 * u * std::max(left.size, right.size);
        const double apart = r + (left_slope + right_slope) * off;
        return std::sqrt(off * off + apart * apart);
    }

    void add_edges() {
        cell_.edges.reserve(diagram_.edges.size());
        for (const EdgeId e : diagram_.edges.ids()) {
            Range heights{std::numeric_limits<double>::infinity(), 0};
            const MinimizationDiagram::Edge& from = diagram_.edges[e];
            CellEdge edge;
            edge.sites[0] = main_site(from.left);
            edge.sites[1] = from.on_rim() ? problem_.region[from.side].site : main_site(from.right);
            for (const FormId f : diagram_.label(e))
                for (const Site site : problem_.sites[f])
                    if (site != edge.sites[0] && site != edge.sites[1]) edge.extra_sites.push_back(site);
            sort_unique(edge.extra_sites);
            const VertexId start = diagram_.dcel.origin(Dcel::half_edge(e));
            if (start.valid()) edge.vertices = {start.value, diagram_.dcel.target(Dcel::half_edge(e)).value};
            edge.kind = kind(e);
            if (mixed_.contains(e)) {
                edge.curve = mixed_space_curve(mixed_.spans(e), heights);
                edge.error = mixed_.error(e).space;
            } else {
                edge.curve = space_curve(e, arcs_.spans(e), degree(e), heights);
                edge.error = circular_edge_error(e);
            }
            edge.error += motion_back(edge.curve);
            add_highest(heights[1], edge.error);
            cell_.edges.push_back(std::move(edge));
        }
        for (const VertexId v : diagram_.vertices.ids())
            add_highest(diagram_.vertices[v].height, cell_.vertices[v.value].error);
    }

    // Every height is convex: over a face it is largest on the face's boundary. A point of the boundary as
    // written is within `error` of one of the true boundary, and the other way round.
    void add_highest(double height, double error) {
        const std::array<double, 3> of_part{height, height - error, height + error};
        for (int i = 0; i < 3; ++i) highest_[i] = std::max(highest_[i], of_part[i]);
    }
    void set_max_clearance() {
        const auto [height, least, most] = highest_;
        cell_.measures.max_clearance = height;
        cell_.measures.max_clearance_error = std::max(height - least, most - height) + 16 * u * height;
    }

    std::vector<TrimCurve> loop(CcbId ccb) const {
        std::vector<TrimCurve> curves;
        const HalfEdgeId start = diagram_.dcel.start(ccb);
        HalfEdgeId h = start;
        do {
            TrimCurve curve;
            const EdgeId e = Dcel::edge(h);
            curve.edge = e.value;
            curve.reversed = h != Dcel::half_edge(e);
            curve.curve = mixed_.contains(e) ? mixed_trim(mixed_.spans(e), curve.reversed)
                                             : trim_curve(arcs_.spans(e), degree(e), curve.reversed);
            curves.push_back(std::move(curve));
            h = diagram_.dcel.next(h);
        } while (h != start);
        return curves;
    }

    // The bounding rectangle of an outer loop.
    std::array<Range, 2> bounds(CcbId ccb) const {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        std::array<Range, 2> box{{{infinity, -infinity}, {infinity, -infinity}}};
        const HalfEdgeId start = diagram_.dcel.start(ccb);
        HalfEdgeId h = start;
        do {
            const EdgeId e = Dcel::edge(h);
            for (const ArcSpan& span : arcs_.spans(e)) {
                const Vector2d m = span.middle();
                for (int i = 0; i < 2; ++i) extend(box[i], span.from[i], m[i], span.to[i], span.weight());
            }
            if (mixed_.contains(e)) extend_by_trim(box, mixed_trim(mixed_.spans(e), h != Dcel::half_edge(e)));
            h = diagram_.dcel.next(h);
        } while (h != start);
        // A face thinner than the spacing of doubles still needs a domain that has two ends.
        for (Range& range : box)
            if (range[0] == range[1]) range[1] = std::nextafter(range[1], infinity);
        return box;
    }

    // Conics by their extremes, all others by their control points.
    static void extend_by_trim(std::array<Range, 2>& box, const RationalCurve2& curve) {
        const auto& p = curve.points;
        if (curve.degree == 2) {
            for (std::size_t k = 0; k + 2 < p.size(); k += 2)
                for (int i = 0; i < 2; ++i)
                    extend(box[i], p[k][i], p[k + 1][i], p[k + 2][i],
                           p[k + 1][2] / std::sqrt(p[k][2] * p[k + 2][2]));
            return;
        }
        for (const Eigen::Vector3d& point : p)
            for (int i = 0; i < 2; ++i) {
                box[i][0] = std::min(box[i][0], point[i]);
                box[i][1] = std::max(box[i][1], point[i]);
            }
    }

    // The height as a Bezier patch on [u0,u1] x [v0,v1]: blossoms. In one variable (u - c)^2 has the
    // coefficients (u0-c)^2, (u0-c)(u1-c), (u1-c)^2, and u itself u0, (u0+u1)/2, u1.
    // rounding: bound on how far that turns the surface off.
    RationalPatch patch(const CircularForm& f, const std::array<Range, 2>& box, double& rounding) const {
        RationalPatch surface;
        const int n = f.k != 0 ? 2 : 1;
        surface.degree_u = surface.degree_v = n;
        surface.domain_u = box[0];
        surface.domain_v = box[1];
        const auto blossom = [n](const Range& r, int i, double c) {
            return (r[i == n] - c) * (r[i > 0] - c);
        };
        const auto abscissa = [n](const Range& r, int i) {
            return i == 0 ? r[0] : i == n ? r[1] : 0.5 * r[0] + 0.5 * r[1];
        };
        double size = 0;
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; j <= n; ++j) {
                const double x = abscissa(box[0], i), y = abscissa(box[1], j);
                const double quadratic =
                    f.k == 0 ? 0 : f.k * (blossom(box[0], i, f.cx) + blossom(box[1], j, f.cy));
                const double z = (quadratic + f.a * x + f.b * y + f.e) / f.w;
                size = std::max(
                    size,
                    (std::abs(quadratic) + std::abs(f.a * x) + std::abs(f.b * y) + std::abs(f.e)) / f.w +
                        std::abs(x) + std::abs(y));
                const Vec3 world = problem_.frame.to_world({x, y, z});
                surface.points.push_back({world.x(), world.y(), world.z(), 1});
            }
        }
        rounding = patch_rounding * (size + problem_.frame.origin.norm());
        return surface;
    }

    // The cone over a cylinder is circular when its axis is: a quadric x^2 + y^2 = (d.X)^2 has the
    // eigenvalues 1 and +-d_z.
    std::string bisector_name(FormId form) const {
        if (!main_site(form).is_object()) return "box";
        if (diagram_.is_circular(form)) return diagram_.forms[form].k != 0 ? "paraboloid" : "plane";
        switch (problem_.axes[form.value - problem_.family.forms.size()]) {
            case AxisToBase::Parallel: return "parabolic cylinder";
            case AxisToBase::Upright: return "circular cone";
            case AxisToBase::Oblique: break;
        }
        return "elliptic cone";
    }

    void add_faces() {
        const std::size_t count = diagram_.dcel.face_count();
        cell_.faces.reserve(count - 1);
        for (std::uint32_t i = 1; i < count; ++i) {
            const FaceId id{i};
            const FormId form = diagram_.face_forms[id];
            CellFace face;
            face.site = main_site(form);
            face.extra_sites.assign(problem_.sites[form].begin() + 1, problem_.sites[form].end());
            face.bisector = bisector_name(form);
            TrimmedPatch trimmed;
            const CcbId outer = diagram_.dcel.outer_ccb(id);
            const std::array<Range, 2> box = bounds(outer);
            double rounding = 0;
            if (diagram_.is_circular(form)) {
                trimmed.surface = patch(diagram_.forms[form], box, rounding);
            } else {
                const CylinderFrame& frame = mixed_.frame(id);
                trimmed.surface = frame.patch(box[0], box[1], problem_.frame);
                for (const Eigen::Vector4d& p : trimmed.surface.points)
                    rounding = std::max(rounding, p.head<3>().norm());
                rounding =
                    patch_rounding * (rounding + frame.height().reach() + problem_.frame.origin.norm());
            }
            // The patch belongs to what the edge's error bounds.
            const auto add_rounding = [&](CcbId ccb) {
                const HalfEdgeId start = diagram_.dcel.start(ccb);
                HalfEdgeId h = start;
                do {
                    cell_.edges[Dcel::edge(h).value].error += rounding;
                    h = diagram_.dcel.next(h);
                } while (h != start);
            };
            add_rounding(outer);
            for (const CcbId inner : diagram_.dcel.inner_ccbs(id)) add_rounding(inner);
            trimmed.loops.push_back(loop(outer));
            for (const CcbId inner : diagram_.dcel.inner_ccbs(id)) trimmed.loops.push_back(loop(inner));
            face.patches.push_back(std::move(trimmed));
            cell_.faces.push_back(std::move(face));
        }
    }

    const PlaneBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const ChartArcs arcs_;
    const MixedArcs mixed_;
    Cell cell_;
    std::array<double, 3> highest_{};  // of the boundary as written, and bounds of the true one's
};

}  // namespace

LiftedCell lift(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance,
                bool with_measures) {
    return Lifter(problem, diagram, tolerance).lift(with_measures);
}

}  // namespace vcell
