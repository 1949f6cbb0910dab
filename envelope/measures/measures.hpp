/// Measures of a lifted cell: volume, areas, lengths, clearances.
#pragma once

#include "../../primitives/bases/plane_base.hpp"
#include "../cell.hpp"
#include "../diagram/chart_arc.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../lift/mixed_arc.hpp"

namespace vcell {

/// Fills in face areas, edge lengths, neighbors and all measures but max_clearance (which the space curves
/// tell) of a cell that is otherwise lifted.
///
/// Errors bound truncation (proven, quadrature.hpp), rounding (first order, doubled) and the effect of the
/// vertices' and arcs' own position errors. base_area has a relative error of 2^-49.
void measure(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, const ChartArcs& arcs,
             const MixedArcs& mixed, Cell& cell);

/// How much longer, over its error, a conic's arc may be than the true one: the arc and its chord bound a
/// convex body. Of two such bodies each within e of the other the perimeters differ by 2 pi e at most
/// [Cauchy's formula], the chords by 2 e.
constexpr double length_sensitivity = 8.3;

/// Fills in neighbors from the areas of the faces; ascending where those are not_measured.
void rank_neighbors(Cell& cell);

}  // namespace vcell
