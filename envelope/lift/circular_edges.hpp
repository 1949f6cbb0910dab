/// Edges between circular forms over a plane base, and their trims: the diagram's arcs, with the height as
/// third coordinate.
#pragma once

#include "../cell.hpp"
#include "../diagram/chart_arc.hpp"
#include "based_diagram.hpp"
#include "joined_spans.hpp"

namespace vcell {

class CircularEdges {
public:
    CircularEdges(const PlaneDiagram& of, unsigned threads)
        : of_(of), diagram_(of.diagram), arcs_(of.problem.family, of.diagram, threads) {}

    const ChartArcs& arcs() const { return arcs_; }

    /// Decided by exact facts only.
    CurveKind kind(EdgeId e) const;
    /// Makes the curve in world coordinates; extends `heights` by its heights.
    void set_curve(EdgeId e, RationalCurve3& curve, Range& heights) const;
    /// Makes the trim on either side, in the direction of its loop: points are (x, y, w) of the chart.
    void set_trim(EdgeId e, bool reversed, RationalCurve2& curve) const;
    /// A bound on the canonical curve's distance from the true edge.
    double error(EdgeId e) const;

private:
    int degree(EdgeId e) const;
    double line_error(EdgeId e) const;

    const PlaneDiagram of_;
    const MinimizationDiagram& diagram_;
    const ChartArcs arcs_;
};

}  // namespace vcell
