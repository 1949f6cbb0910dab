/// From the minimization diagram of a plane base to the cell: patches, space curves, vertices, measures.
#pragma once

#include "../../primitives/bases/plane_base.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "lifted_cell.hpp"

namespace vcell {

/// The cell of a problem's diagram, without its scene, timings and warnings (the caller's to add);
/// report.decisions counts the diagram's signs and the few taken here.
///
/// Patches have u = x, v = y of the canonical frame and the face's bounding rectangle as domain; they are the
/// heights exactly: (2,2) over a sphere, (1,1) over a plane or a side of the box. So trimming curves are
/// the diagram's arcs, and an edge's space curve is its arc with a third coordinate, on the same knots and
/// weights. Over a cylinder a patch is exact too, of degree (1,2) in parameters of its own
/// (cylinder_patch.hpp); edges beside it are exact conics with rational cubic trims where the other side is
/// linear or the rim, and otherwise splines within `tolerance` (length) of the true arc (space_spline.hpp).
/// Vertex i, edge i and face i + 1 of the diagram (face 0 is the unbounded one) become vertex, edge
/// and face i of the cell.
/// Measures are left out (CellOptions::measure) without `with_measures`.
/// Pre: diagram is the lower envelope of problem.family over problem.region; tolerance > 0.
LiftedCell lift(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance,
                bool with_measures = true);

}  // namespace vcell
