/// Faces over a base plane as loops of curves in its chart.
#pragma once

#include <deque>
#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

using ChartLoop = std::vector<const TrimCurve*>;

/// Patches over cylinders, and in them, have parameters of their own: in the chart their trims are the
/// projections of the edges' space curves, of which rational curves have exact ones. Others are the patches'
/// trims themselves.
struct ChartLoops {
    /// None of those through which a complete cell's rays come in. They point into the cell and to
    /// `projected`.
    std::vector<std::vector<ChartLoop>> of_faces;
    std::deque<TrimCurve> projected;
};

/// Pre: the base is a plane.
ChartLoops chart_loops(const Cell& cell);

}  // namespace vcell
