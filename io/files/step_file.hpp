/// STEP (ISO 10303-21, AP214) of a cell around a ball: a closed solid for CAD.
#pragma once

#include <iosfwd>
#include <string>

#include "../../envelope/cell.hpp"

namespace vcell {

/// One MANIFOLD_SOLID_BREP: each face an ADVANCED_FACE named after its site, in its colour, on the rational
/// Bezier surface of its patch; each edge a rational B-spline curve in space with its curves in the
/// parameters of both surfaces. Nothing is approximated again: curves and surfaces are the cell's, and the
/// file's uncertainty is 1.2 times the largest of what edges state as their error and vertices are off by (at
/// least 1e-7). Units are those of the scene if they are m, cm, mm, um or nm, otherwise they are taken for
/// mm. No time is in the file: the same cell makes the same bytes.
///
/// Throws InputError for a cell that is no closed solid of faces with one patch each: cells over planes and
/// tubes have walls, floors and ends that are no faces of the cell.
void write_step(std::ostream& out, const Cell& cell);

}  // namespace vcell
