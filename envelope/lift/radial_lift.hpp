/// From the minimization diagram of a sphere or cylinder base to the cell.
#pragma once

#include "../../primitives/bases/radial_base.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "lifted_cell.hpp"

namespace vcell {

/// As lift() over a plane base. Face i of the cell is the i-th face of the diagram that has a form; vertices
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
/// (length) of the true arc. Pre: diagram is the lower envelope of problem.family over the whole base;
/// tolerance > 0.
LiftedCell lift(const RadialBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance,
                bool with_measures = true);

}  // namespace vcell
