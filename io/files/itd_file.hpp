/// IRIT's data files (.itd): the cell as trimmed surfaces, edge curves and vertices.
#pragma once

#include <iosfwd>

#include "../../envelope/cell.hpp"

namespace vcell {

/// An object for each patch, "FACE3_0" with the attribute `neighbor` ("7", "box:-x", ...), a TRIMSRF in the
/// colour of its site: a Bezier surface over [0, 1]^2, each loop a TRIMCRV of rational B-spline curves in its
/// parameters, outer loops first. Then the edges, "EDGE5", as curves in space, and the vertices, "VERTEX2",
/// as points, with their `clearance`. World coordinates, all digits.
void write_itd(std::ostream& out, const Cell& cell);

}  // namespace vcell
