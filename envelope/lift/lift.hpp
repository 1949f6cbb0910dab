/// From the minimization diagram of a base to the cell: patches, space curves, vertices, measures.
#pragma once

#include "../../core/ids.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../cell.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

/// What a lift leaves to voronoi_cell().
struct LiftedCell {
    Cell cell;
    /// Bounds on the distances of the edges' space curves from the true edges. Their errors bound the trims,
    /// too, which may be far worse: of these nothing follows for where an edge is.
    IdVector<EdgeId, double> positions;
};

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
/// Measures are left out (CellOptions::measure) without `with_measures`. The cell is the same for any number
/// of threads.
/// Pre: diagram is the lower envelope of problem.family over problem.region; tolerance > 0.
LiftedCell lift_over_region(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram,
                            double tolerance, bool with_measures, unsigned threads = 1);

/// As lift_over_region(). Face i of the cell is the i-th face of the diagram that has a form; vertices
/// and edges keep their numbers.
///
/// Sphere base: an edge between circular forms is the projective image of a circle's arc on the sphere, a
/// conic, and the trims on both sides are projective images of the same arc: rational quadratics in one
/// parameter, exact. Beside planes and sides of the box the patch has the plane's coordinates, (2,2) or
/// (1,1), polynomial; beside spheres it is the rational biquadratic in a stereographic chart about the face,
/// whose pole lies outside it.
///
/// Cylinder base: edges between planes, sides of the box, ends and cylinders along the base are lines and
/// conics, exact, with rational cubics for trims on patches around the base (axial_conic.hpp).
///
/// Everything else (faces of cylinders over a sphere, edges beside them or beside balls and skew cylinders
/// over a cylinder) has patches of the bisector's rational parametrization and splines within `tolerance`
/// (length) of the true arc.
///
/// With a floor (RadialBaseProblem::floor) of faces that the problem shows only: edges beside none of them
/// have no curve, and vertices of such edges alone no place. Measures are those of the faces, and the volume
/// that between them and the axis. The cell is the same for any number of threads.
/// Pre: diagram is the lower envelope of problem.family over the whole base; tolerance > 0.
LiftedCell lift_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                           double tolerance, bool with_measures, unsigned threads = 1);

/// As lift_all_around(), but for the patches of the faces, where edges and measures do without: around a
/// sphere, and around a cylinder in a vessel. There the edges' errors bound the distance from the true edge
/// alone.
LiftedCell lift_without_patches(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                double tolerance, bool with_measures, unsigned threads = 1);
/// Lifts as lift_without_patches() does where not all edges are conics: no patch has to hold a face, which
/// may be of any shape.
LiftedCell lift_curves_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                  double tolerance, bool with_measures, unsigned threads = 1);

/// The curves of edges between two objects, for their own sake: as lift_all_around() has them where no patch
/// has to hold a face. Other edges have none, faces no patches, and there are no measures; errors bound the
/// distance from the true edge alone. Pre: the problem has no floor.
LiftedCell lift_curves_between_objects(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                       double tolerance);

}  // namespace vcell
