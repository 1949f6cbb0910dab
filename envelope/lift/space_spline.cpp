#include "space_spline.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "space_guide.hpp"
#include "space_trims.hpp"

namespace vcell {

namespace {

using namespace space_fit;
using std::numbers::pi;

Equation equation_of(const BaseChart& chart, const SpaceSite& site, const Vec3& foot) {
    Equation equation = site_equation(chart, site.object, site.is_wall, foot);
    if (site.power) equation.set_power(*site.power);
    return equation;
}

// An edge as its fit's guide: the pieces of the diagram, and trims.
class EdgeGuide {
public:
    using Piece = space_fit::Piece;
    using Span = SpaceSpan;
    using Trims = space_fit::Trims;

    EdgeGuide(const SpaceArc& arc, const ArcEquations& equations, const ArcGuide& pieces)
        : arc_(arc), equations_(equations), pieces_(pieces) {}

    static SpaceSpan span(const Points& points, const Trims& trims) { return {points, trims.part}; }
    Vector4d end_of(const Piece& piece) const { return pieces_.lifted(piece.end); }
    bool holds(const Piece& piece, const Vector4d& X, double slack) const {
        const Vec2 q = pieces_.chart_point(X, piece);
        const auto& [x0, x1, y0, y1] = piece.box;
        return q.x() >= x0 - slack && q.x() <= x1 + slack && q.y() >= y0 - slack && q.y() <= y1 + slack;
    }
    Trims place_trims(Points& points, double tolerance) const {
        return space_fit::place_trims(arc_, tolerance, points);
    }
    static TrimProof prove_trims(const TubeProof& proof, const Points& points, const Trims& trims,
                                 const SpanPolynomials& span, const Residuals& residuals) {
        return {proof, trims.patches, points, span, residuals};
    }

    std::optional<Node> half_way(const Node& from, const Node& to, const Piece* piece, const Points& points,
                                 const Trims& trims, double tolerance) const {
        if (trims.seam)
            if (const auto crossing = sign_change(points, *trims.seam, tolerance))
                if (const auto found = equations_.find(*crossing, &*trims.seam);
                    found && is_between(from, *found, to))
                    return found;
        if (trims.seam)
            if (const auto found = equations_.find(point(points, 0.5)); found && is_between(from, *found, to))
                return found;
        if (!piece) {
            Vec3 w = from.X.head<3>() / from.X[3] + to.X.head<3>() / to.X[3];
            w.y() = 0;
            return equations_.node(pieces_.over(Vec3(0, from.X.y(), 0), w.normalized()));
        }
        const auto on_line = pieces_.meet(
            0.5 * (pieces_.chart_point(from.X, *piece) + pieces_.chart_point(to.X, *piece)), *piece);
        return equations_.find(on_line ? pieces_.lifted(*on_line) : Vector4d(0.5 * (from.X + to.X)));
    }

    std::optional<SpaceBox> enclosure(const Chord& chord, const Piece* piece, FitEffort& effort) const {
        // Where there is no piece whole edges only: parts may end where the edge does, as far as is known.
        if (!piece)
            return chord.is_all ? std::optional(pieces_.rim_enclosure(chord.from, chord.to, chord.slack))
                                : std::nullopt;
        // Elsewhere the diagram is not needed, and not relied on.
        const double length = (chord.to.X - chord.from.X).norm();
        const bool is_blurred_part =
            is_blurred(equations_, chord.from.X, length) || is_blurred(equations_, chord.to.X, length);
        if (chord.is_all || is_blurred_part) {
            const auto tight =
                pieces_.enclosure_between(chord.from, chord.to, *piece, chord.slack, effort.cells);
            // Nothing but the last span may reach the edge's end, or step 4 would end there early.
            const bool holds_end = (chord.end - tight[0]).minCoeff() >= -chord.slack &&
                                   (tight[1] - chord.end).minCoeff() >= -chord.slack;
            if (!holds_end || chord.from.is_terminal || chord.to.is_terminal) return tight;
        }
        return pieces_.enclosure(piece->box);
    }

private:
    const SpaceArc& arc_;
    const ArcEquations& equations_;
    const ArcGuide& pieces_;
};

class EdgeFit {
public:
    EdgeFit(const BaseChart& chart, const SpaceArc& arc)
        : chart_(chart),
          arc_(arc),
          foot_(arc.start            ? chart.foot_below(arc.start->point)
                : arc.pieces.empty() ? chart.foot_below(std::get<Plane>(arc.sites[1].object).point)
                                     : chart.foot(arc.pieces.back().end)) {
        equations_.set(base_equation(chart, foot_), equation_of(chart, arc.sites[0], foot_),
                       equation_of(chart, arc.sites[1], foot_));
        if (arc.sites_cross) take_plane();
        if (!arc.start && arc.pieces.empty()) return;
        const Vector4d X = first_point();
        if (arc.twins && !equations_.is_replaced)
            equations_.tell_apart(*arc.twins, X);
        else if (!arc.pieces.empty())
            equations_.tell_apart(X);
        equations_.tell_from_base(X);
    }

    SpaceFitError run(double tolerance, std::vector<SpaceSpan>& spans, FitEffort& effort) const {
        const bool on_rim = arc_.pieces.empty();
        const ArcEnd start = arc_.start ? end_at(*arc_.start) : on_rim ? ArcEnd{rim_node(0), 0} : cut();
        std::optional<ArcEnd> end;
        if (arc_.end) end = end_at(*arc_.end);
        const EdgeGuide guide(arc_, equations_, guide_);
        SplineFit<EdgeGuide> fit(guide, equations_, foot_, tolerance, start, end, spans, effort);
        if (on_rim)
            fit.fit_by_way_of(rim_nodes());
        else
            fit.fit_all(arc_.pieces);
        return fit.error();
    }

private:
    ArcEnd end_at(const SpaceEnd& e) const {
        return {equations_.node(chart_.with_distance(e.point)), sqrt2 * e.error};
    }

    // Where cylinders of one radius cross, their equations depend on each other in the points over both axes.
    // An arc lies in one of the planes between the axes, whose equation takes the place of the right one's.
    // Which plane, and on which side of it the right one is nearer, an inner point of the arc tells.
    void take_plane() {
        const auto inner = inner_point();
        if (!inner) return;
        const auto &f = std::get<Cylinder>(arc_.sites[0].object),
                   &g = std::get<Cylinder>(arc_.sites[1].object);
        const Vec3 a = f.axis.normalized(), b = g.axis.normalized(), normal = a.cross(b);
        const Vec3 center = f.point + (g.point - f.point).cross(b).dot(normal) / normal.squaredNorm() * a;
        const std::array<Vec3, 2> sums{a - b, a + b};
        const double least = std::min(sums[0].norm(), sums[1].norm());
        const std::array<Vec3, 2> normals{sums[0].normalized(), sums[1].normalized()};
        const Vec3 p = inner->head<3>() - center;
        const Vec3& n = normals[std::abs(normals[1].dot(p)) < std::abs(normals[0].dot(p))];
        const double side =
            n.dot((equations_[2].gradient(*inner) - equations_[1].gradient(*inner)).head<3>());
        equations_.replace_right(
            Equation::between(center, side > 0 ? n : Vec3(-n), rounding / (least * least)));
    }
    Vector4d first_point() const {
        return arc_.start ? chart_.with_distance(arc_.start->point) : guide_.lifted(arc_.pieces.back().end);
    }
    // Of those that the pieces tell the one farthest from the ends.
    std::optional<Vector4d> inner_point() const {
        if (!arc_.start || !arc_.end) return std::nullopt;
        const Vector4d from = chart_.with_distance(arc_.start->point),
                       to = chart_.with_distance(arc_.end->point);
        std::optional<Vector4d> best;
        double farthest = 0;
        const auto offer = [&](const Vector4d& X) {
            const double distance = std::min((X - from).norm(), (X - to).norm());
            if (distance > farthest) best = X;
            farthest = std::max(farthest, distance);
        };
        for (const Piece& piece : arc_.pieces.first(arc_.pieces.size() - 1)) offer(guide_.lifted(piece.end));
        if (arc_.pieces.size() == 1) {
            const Piece& piece = arc_.pieces.front();
            if (const auto q = guide_.meet(
                    0.5 * (guide_.chart_point(from, piece) + guide_.chart_point(to, piece)), piece))
                offer(guide_.lifted(*q));
        }
        return best;
    }

    // Around a cylinder: with growing angle on the lower end, the region lying on the left.
    Node rim_node(double angle) const {
        const double y = std::get<Plane>(arc_.sites[1].object).point.y();
        return equations_.node(guide_.over(Vec3(0, y, 0), Vec3(std::sin(angle), 0, std::cos(angle))));
    }
    // Between the ends of a rim's arc.
    std::vector<Node> rim_nodes() const {
        constexpr double widest = pi / 3;
        const double sign = std::get<Plane>(arc_.sites[1].object).normal.y() < 0 ? 1 : -1;
        const auto angle = [](const SpaceEnd& e) { return std::atan2(e.point.x(), e.point.z()); };
        const double first = arc_.start ? angle(*arc_.start) : 0;
        double turn = arc_.turn > 0 ? arc_.turn : 2 * pi;
        if (!(arc_.turn > 0) && arc_.end && arc_.end->point != arc_.start->point) {
            turn = std::fmod(sign * (angle(*arc_.end) - first), 2 * pi);
            if (turn < 0) turn += 2 * pi;
        }
        const int n = std::max(1, static_cast<int>(std::ceil(turn / widest)));
        std::vector<Node> nodes;
        for (int i = 1; i < n; ++i) nodes.push_back(rim_node(first + sign * turn * i / n));
        return nodes;
    }

    // Where a closed edge is cut, and how far that may be from a point of the edge.
    ArcEnd cut() const {
        const Piece& piece = arc_.pieces.back();
        const Node node = piece_end(equations_, guide_.lifted(piece.end));
        const double e = piece.error;
        const auto box =
            guide_.enclosure({piece.end.x() - e, piece.end.x() + e, piece.end.y() - e, piece.end.y() + e});
        return {node, (node.X - box[0]).cwiseAbs().cwiseMax((node.X - box[1]).cwiseAbs()).norm()};
    }

    const BaseChart& chart_;
    const SpaceArc& arc_;
    Vec3 foot_;  // near the curve
    ArcEquations equations_;
    ArcGuide guide_{chart_, arc_, equations_};
};

}  // namespace

// Within a ball of twice the bound the solution is unique by step 2, and the point is one.
std::optional<SpaceEnd> settle_point(const BaseChart& chart, const std::array<SpaceSite, 3>& sites,
                                     const SpaceEnd& near) {
    const Vec3 foot = chart.foot_below(near.point);
    const Vector4d center = chart.with_distance(near.point);
    const Equation base = base_equation(chart, foot);
    const auto beside = [&](int i) {
        return Equation::beside(base, equation_of(chart, sites[i], foot), center);
    };
    const std::array equations{base, beside(0), beside(1), beside(2)};
    const double radius = 2 * sqrt2 * near.error;
    Matrix4d M;
    std::array<double, 4> variations, e;
    for (int i = 0; i < 4; ++i) {
        M.row(i) = equations[i].gradient(center);
        variations[i] = equations[i].variation(center, radius);
    }
    const Solver solver(M, variations);
    if (!solver.is_regular()) return std::nullopt;
    Vector4d X = center;
    constexpr int steps = 3;  // of q each
    for (int k = 0; k < steps; ++k) {
        Vector4d G;
        for (int i = 0; i < 4; ++i) G[i] = equations[i](X);
        X -= solver.inverse * G;
    }
    for (int i = 0; i < 4; ++i) e[i] = equations[i].residual(X);
    const double error = solver.distance(e);
    if (!(error < near.error && (X - center).norm() + error <= radius)) return std::nullopt;
    return SpaceEnd{X.head<3>(), error};
}

SpaceFitError fit_space_spline(const BaseChart& chart, const SpaceArc& arc, double tolerance,
                               std::vector<SpaceSpan>& spans, FitEffort& effort) {
    const std::size_t first = spans.size();
    const SpaceFitError error = EdgeFit(chart, arc).run(tolerance, spans, effort);
    if (arc.is_turned)
        for (SpaceSpan& span : std::span(spans).subspan(first)) {
            span.points.middleRows<2>(4).swap(span.points.middleRows<2>(6));
            std::swap(span.part[0], span.part[1]);
        }
    return error;
}

}  // namespace vcell
