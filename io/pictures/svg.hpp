/// SVG pictures of minimization diagrams.
#pragma once

#include <cstddef>
#include <iosfwd>

#include "../../envelope/cell.hpp"

namespace vcell {

struct SvgOptions {
    /// Level curves of the clearance within each face: at most so many levels, round ones with equal steps
    /// (class `contour`, named where there is room). Arcs of circles and lines are exact, other curves
    /// polylines within 1e-4 of the cell's diagonal.
    std::size_t contours = 0;
};

/// The minimization diagram of a cell. A plane base: in chart coordinates (u to the right, v upwards), from
/// the trimming loops of its patches; lines and circular arcs are exact, other curves are cubic pieces that
/// stay within a millionth of the picture's size. Spheres and cylinders: unfolded (unfold.hpp), as polylines.
///
/// A face is a path with its site's colour and a tooltip, and where there is room its object's name, or
/// number; vertices are circles that tell their clearance. Below are, over a plane, a bar with its length,
/// and what is hatched. Styled by CSS classes (face, box, edge, rim, vertex, panel, c0 ... c7), without
/// scripts.
void write_svg(std::ostream& out, const Cell& cell, const SvgOptions& options = {});

}  // namespace vcell
