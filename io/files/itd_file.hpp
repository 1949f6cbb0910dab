/// IRIT's data files (.itd): a cell, or all of a diagram, as trimmed surfaces, edge curves and vertices.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>

#include "../../envelope/cell.hpp"
#include "../pictures/diagram_pictures.hpp"

namespace vcell {

/// An object for each patch, "FACE3_0" with the attribute `neighbor` ("7", "box:-x", ...), a TRIMSRF in the
/// colour of its site: a Bezier surface over [0, 1]^2, each loop a TRIMCRV of rational B-spline curves in its
/// parameters, outer loops first. Then the edges, "EDGE5", as curves in space, and the vertices, "VERTEX2",
/// as points, with their `clearance`. World coordinates, all digits.
void write_itd(std::ostream& out, const Cell& cell);

/// The cells of a diagram, one after the other as they are computed (DiagramOptions::visit): objects as
/// write_itd() has them, named "CELL7_FACE3_0" (of a plane's second cell "CELL7B_FACE3_0"), in one colour for
/// each cell.
class DiagramItd {
public:
    explicit DiagramItd(std::ostream& out) : out_(out) {}

    void add(std::uint32_t object, const Cell& cell);

private:
    std::ostream& out_;
    std::optional<std::uint32_t> last_;
    CellColours colours_;
};

}  // namespace vcell
