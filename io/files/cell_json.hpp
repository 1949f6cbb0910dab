/// Cells as JSON values, for files that hold several.
#pragma once

#include <cstdint>
#include <optional>

#include "../../envelope/cell.hpp"
#include "json_reader.hpp"
#include "json_writer.hpp"

namespace vcell {

struct CellOfDiagram {
    std::uint32_t object = 0;
    std::optional<bool> side;  ///< of a plane: does the cell lie where its normal points?
    std::optional<Box> box;    ///< of no ball, in a box that repeats: what its cell lies in, one period of it
    Cell cell;
};
/// The cell of an object of a diagram, without its scene, which is the diagram's.
void write_cell_of_diagram(JsonWriter& out, std::uint32_t object, std::optional<bool> side,
                           std::optional<Box> box, const Cell& cell);
CellOfDiagram read_cell_of_diagram(JsonReader& in);

}  // namespace vcell
