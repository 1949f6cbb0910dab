/// The cell of all of the box that is nearest to a base plane, or to a part of a base tube.
///
/// Let e be the upper envelope of the problem's floor and h the lower envelope of its other forms: the ray of
/// the base point q is in the cell from e(q) to h(q) where e <= h. So the cell's boundary is the roof, h over
/// D = {e <= h}, and the floor, e over D, without the base's own region in the box, where e = 0; and the
/// sides of the box along the normal, which no face stands over. Two diagrams have all of that:
///
///     max(h, e)   over D it is that of h, with the roof's faces; elsewhere its faces are the floor's, and
///     dropped min(h, e)   over D it is that of e, with the floor's faces; elsewhere its faces are the roof's
///
/// Both show the boundary of D, where h = e: the same curves, as {h_i = e_w} has the roof's i and the floor's
/// w beside it, and the same vertices, in which three forms tie, or two and a side of the region. Faces of
/// the roof and of the floor share these edges. A name of forms and sides may be that of two points: which is
/// which their errors tell.
///
/// Where the wall of a vessel cuts a base plane's region the base is the floor, or its lowest part, for a
/// cell that is not complete, too: h < 0 beyond the wall, D is within it, and its boundary there has the wall
/// on both sides.
///
/// Seen from outside, the floor is seen against the normal's sense: there left and right change, and u and v.
/// An edge between two of its faces is turned round, so that its left site stays left of it.
///
/// Volumes are the roof's less the floor's, and so are walls under the rim; areas are added.
#pragma once

#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "lift.hpp"

namespace vcell {

/// As lift_over_region(), from the diagram above the floor and that below it. Numbers are those of the roof's
/// elements that stay, then of the floor's.
/// Throws UndecidedError where vertices of both diagrams cannot be told to be the same.
/// Pre: the diagrams are those of problem.family with problem.floor, over problem.region; tolerance > 0.
LiftedCell lift_complete(const PlaneBaseProblem& problem, const MinimizationDiagram& above,
                         MinimizationDiagram below, double tolerance, bool with_measures, unsigned threads);

/// As lift_all_around(), of a part of a base cylinder with a floor (CylinderPart): with areas and lengths,
/// but without Cell::measures.
LiftedCell lift_complete_part(const RadialBaseProblem& problem, const MinimizationDiagram& above,
                              MinimizationDiagram below, double tolerance, bool with_measures);

}  // namespace vcell
