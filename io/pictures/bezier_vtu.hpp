/// A cell's exact surfaces and curves for VTK, as its rational Bezier elements.
#pragma once

#include <iosfwd>

#include "../../envelope/cell.hpp"

namespace vcell {

/// VTK XML unstructured grid, arrays in base64: each patch a VTK_BEZIER_QUADRILATERAL over the rectangle of
/// its parameters, which holds its loops and is not trimmed by them, and each Bezier span of an edge a
/// VTK_BEZIER_CURVE. Control points and weights are the cell's. Cell data: `face` and `edge`, the number of
/// what the element is of (-1 of the other one), and `neighbor`, the site beyond a face, or the first one of
/// an edge, as LabelledMesh has it. Throws WriteError for a patch or a curve of a degree above 10, which VTK
/// has no room for.
void write_bezier_vtu(std::ostream& out, const Cell& cell);

}  // namespace vcell
