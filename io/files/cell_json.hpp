/// Cells as JSON values, for files that hold several.
#pragma once

#include <cstdint>
#include <optional>

#include "../../envelope/cell.hpp"
#include "json_reader.hpp"
#include "json_writer.hpp"

namespace vcell {

/// The cell of an object of a diagram, without its scene, which is the diagram's. `side`: of a plane, whether
/// the cell lies where its normal points, or on the other side.
void write_cell_of_diagram(JsonWriter& out, std::uint32_t object, std::optional<bool> side, const Cell& cell);

struct CellOfDiagram {
    std::uint32_t object = 0;
    std::optional<bool> side;
    Cell cell;
};
CellOfDiagram read_cell_of_diagram(JsonReader& in);

}  // namespace vcell
