/// STEP (ISO 10303-21, AP214) of a cell: a closed solid for CAD.
#pragma once

#include <iosfwd>

#include "../../envelope/cell.hpp"

namespace vcell {

/// A MANIFOLD_SOLID_BREP for each connected part, most often one, the base's own body included: what closes
/// the cell (closed_shell()) are planar faces. Each other ADVANCED_FACE is a patch of a face, named after its
/// site, in its colour, on the rational Bezier surface of the patch, written as a B-spline with inner knots
/// (with_knots()) by which other programs find its integrals; each edge a rational B-spline curve in space
/// with its curves in the parameters of both surfaces, cut where seams end. Tips of hollow tubes' and cones'
/// bisectors are corners of caps (with_tip_caps()). Nothing else is approximated
/// again: curves and surfaces are the cell's, and the file's uncertainty is 1.2 times the largest of what
/// edges state as their error and vertices and seams are off by (at least 1e-7). An edge no longer than that
/// is left out, and its ends are one vertex; in a cell below 0.1 one no longer than a millionth of it. Units
/// are those of the scene if they are m, cm, mm, um or nm, otherwise they are taken for mm. No time is in the
/// file: the same cell makes the same bytes. Parts of a tube's complete cell are one solid where
/// joined_parts() joins them: a face goes on beyond such an end as another ADVANCED_FACE, and its edges there
/// have curves in its parameters that are fitted anew where both parts run through them unalike.
void write_step(std::ostream& out, const Cell& cell);

}  // namespace vcell
