/// Measures of a lifted cell over a sphere or cylinder base.
#pragma once

#include "../../primitives/bases/radial_base.hpp"
#include "../cell.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

/// Fills in face areas, edge lengths, neighbors and all measures of a cell that is otherwise lifted: its
/// edges have the diagram's numbers and space curves made of Bezier spans, and face i is the i-th face of the
/// diagram that has a form.
///
/// Over a cylinder base the cell is what lies over the base's stretch: flat ends in the planes across the
/// axis close it. box_area has the ends' rings around the base in it.
///
/// Errors hold truncation (radial_integrals.hpp), rounding (first order, doubled) and the effect of the
/// errors of vertices and edges. Beside edges that are no conics over a sphere truncation is estimated from
/// two rules' difference, the gap between two bisectors from points of the edge, doubled: is_estimated says
/// so. Lengths of conics are proven over both bases. positions: bounds on the distances of the edges' space
/// curves from the true edges.
void measure(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
             const IdVector<EdgeId, double>& positions, Cell& cell);

}  // namespace vcell
