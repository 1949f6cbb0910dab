/// Measures of a lifted cell: volume, areas, lengths, clearances.
#pragma once

#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../cell.hpp"
#include "../diagram/chart_arc.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../lift/face_loops.hpp"
#include "../lift/mixed_arc.hpp"

namespace vcell {

/// Fills in face areas, edge lengths, neighbors and all measures but max_clearance (which the space curves
/// tell) of a cell that is otherwise lifted.
///
/// With a floor (EnvelopeOptions::floor), of faces that the problem shows: below the floor the volume is that
/// below them, and walls count as less than nothing, both to be taken away. min_clearance is left out then.
///
/// Errors bound truncation (proven, quadrature.hpp), rounding (first order, doubled) and the effect of the
/// vertices' and arcs' own position errors. base_area has a relative error of 2^-49.
void measure_over_region(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram,
                         const ChartArcs& arcs, const MixedArcs& mixed, const FaceLoops& loops, Cell& cell,
                         unsigned threads);

/// Fills in face areas, edge lengths, neighbors and all measures of a cell that is otherwise lifted: its
/// edges have the diagram's numbers and space curves made of Bezier spans, and face i is the i-th face of the
/// diagram that has a form.
///
/// Over a cylinder base the cell is what lies over the base's stretch: flat ends in the planes across the
/// axis close it. box_area has the ends' rings around the base in it.
///
/// Errors hold truncation (radial_integrals.hpp), rounding (first order, doubled) and the effect of the
/// errors of vertices and edges. Beside edges that are no conics over a sphere, and around tips, truncation
/// is estimated from two rules' difference, the gap between two bisectors from points of the edge, doubled:
/// is_estimated says so. Lengths of conics are proven over both bases. positions: bounds on the distances of
/// the edges' space curves from the true edges.
void measure_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                        const IdVector<EdgeId, double>& positions, Cell& cell, unsigned threads);

/// How much longer, over its error, a conic's arc may be than the true one: the arc and its chord bound a
/// convex body. Of two such bodies each within e of the other the perimeters differ by 2 pi e at most
/// [Cauchy's formula], the chords by 2 e.
constexpr double length_sensitivity = 8.3;

/// Fills in neighbors from the areas of the faces; ascending where those are not_measured.
void rank_neighbors(Cell& cell);

}  // namespace vcell
