/// The arcs of a minimization diagram, ready for output: rational quadratic spans with end points at the
/// diagram's vertices, computed without the centre of a circle so that nearly straight arcs lose nothing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../primitives/forms/form_family.hpp"
#include "minimization_diagram.hpp"

namespace vcell {

/// The gradient of f at p, plain double arithmetic.
inline Eigen::Vector2d gradient(const CircularForm& f, const Eigen::Vector2d& p) {
    return {(2 * f.k * (p.x() - f.cx) + f.a) / f.w, (2 * f.k * (p.y() - f.cy) + f.b) / f.w};
}

/// z component of the cross product: positive when q points to the left of p.
inline double cross(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return p.x() * q.y() - p.y() * q.x();
}

/// A circular arc that turns by 2 half_angle on its way (positive: counter-clockwise), or a segment
/// (half_angle 0). |half_angle| <= 0.8.
///
/// Its rational quadratic Bezier form has the control points from, middle(), to and the weights 1,
/// weight(), 1. The chord makes the angle half_angle with both end tangents; they meet at middle().
struct ArcSpan {
    Eigen::Vector2d from, to;
    double half_angle = 0;

    Eigen::Vector2d chord() const { return to - from; }
    Eigen::Vector2d middle() const { return beside_chord(std::tan(half_angle)); }
    double weight() const { return std::cos(half_angle); }
    /// The point half-way along the arc; the tangent there is parallel to the chord.
    Eigen::Vector2d half_way() const { return beside_chord(std::tan(0.5 * half_angle)); }
    /// 1 / radius, positive where the arc turns left.
    double curvature() const { return half_angle == 0 ? 0 : 2 * std::sin(half_angle) / chord().norm(); }
    double length() const {
        return chord().norm() * (half_angle == 0 ? 1 : half_angle / std::sin(half_angle));
    }
    ArcSpan reversed() const { return {to, from, -half_angle}; }
    std::array<ArcSpan, 2> halves() const {
        const Eigen::Vector2d m = half_way();
        return {{{from, m, 0.5 * half_angle}, {m, to, 0.5 * half_angle}}};
    }

private:
    // The chord's midpoint, moved to its right by `height` half chords.
    Eigen::Vector2d beside_chord(double height) const {
        const Eigen::Vector2d d = chord();
        return 0.5 * (from + to) + 0.5 * height * Eigen::Vector2d(d.y(), -d.x());
    }
};

/// Every edge of a diagram between circular forms as a chain of spans, in the direction of half-edge 2e. A
/// full circle is four spans; an arc of more than 1.6 rad has several. Edges with a cylinder on a side have
/// none here (mixed_arc.hpp).
class ChartArcs {
public:
    ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram);
    /// Of these edges only, ascending; the others have none.
    ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram, std::span<const EdgeId> edges);

    std::span<const ArcSpan> spans(EdgeId e) const {
        return {spans_.data() + offsets_[e.value], spans_.data() + offsets_[e.value + 1]};
    }
    /// Bound on the distance of the spans from the true arc, in the chart.
    double error(EdgeId e) const { return errors_[e]; }
    /// Is the edge's curve a line of the chart? Decided exactly.
    bool is_line(EdgeId e) const { return is_line_[e]; }
    const Decisions& decisions() const { return decisions_; }

private:
    struct Circle {
        Eigen::Vector2d center;
        double radius;
    };

    template <class Edges>
    ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram, const Edges& edges,
              std::size_t count);

    void add_edge(EdgeId e);
    void add_line(EdgeId e);
    void add_full_circle(EdgeId e, double turn, const Circle& circle);
    void add_circular_arc(EdgeId e, double turn);
    void add_around_center(EdgeId e, const Circle& circle, double angle);
    // The exact form's terms in |p|^2: a form has several edges, and making it exact is dear.
    struct Curvature {
        Exact K, W;
    };
    const Curvature& exact_curvature(FormId f);
    Sign curvature_sign(FormId f, FormId g);
    Circle circle(FormId f, FormId g) const;
    double exact_turn(EdgeId e, double turn);
    FormId circular_successor(EdgeId e, VertexId v) const;
    bool is_lower_along(EdgeId e, FormId third) const;
    bool ends_at_circular(EdgeId e) const;
    bool is_taken_beyond(EdgeId e, const Circle& circle, double turn, double off);
    bool is_major_arc(EdgeId e, const Circle& circle);

    const FormFamily& family_;
    const MinimizationDiagram& diagram_;
    std::vector<ArcSpan> spans_;
    std::vector<std::uint32_t> offsets_;
    IdVector<EdgeId, double> errors_;
    IdVector<EdgeId, bool> is_line_;
    Decisions decisions_;
    std::vector<std::optional<Curvature>> curvatures_;  // of forms for which doubles did not do
};

}  // namespace vcell
