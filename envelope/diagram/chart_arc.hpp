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

#include "../../core/threads.hpp"
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
    /// Threads make parts of the edges each; the number of them changes no span.
    ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram, unsigned threads = 1);
    /// Of these edges only, ascending; the others have none.
    ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram, std::span<const EdgeId> edges);

    std::span<const ArcSpan> spans(EdgeId e) const {
        const Part& part = parts_[task_of(e.value)];
        const std::uint32_t* ends = part.ends.data() + e.value % elements_of_task;
        return {part.spans.data() + ends[0], part.spans.data() + ends[1]};
    }
    /// Bound on the distance of the spans from the true arc, in the chart.
    double error(EdgeId e) const { return errors_[e]; }
    /// Is the edge's curve a line of the chart? Decided exactly.
    bool is_line(EdgeId e) const { return is_line_[e] != 0; }
    const Decisions& decisions() const { return decisions_; }

private:
    class Maker;
    // What one task makes, of the edges that it has.
    struct Part {
        std::vector<ArcSpan> spans;
        std::vector<std::uint32_t> ends;  // where one edge's spans end and the next one's begin
        Decisions decisions;
    };

    template <class Visit>
    void make(const FormFamily& family, const MinimizationDiagram& diagram, unsigned threads,
              const Visit& visit);

    std::vector<Part> parts_;
    IdVector<EdgeId, double> errors_;
    IdVector<EdgeId, std::uint8_t> is_line_;  // no bits: threads write it side by side
    Decisions decisions_;
};

}  // namespace vcell
