/// Cells as JSON values, for files that hold several.
#pragma once

#include <cstdint>
#include <utility>

#include "../../envelope/cell.hpp"
#include "json_reader.hpp"
#include "json_writer.hpp"

namespace vcell {

/// The cell of an object of a diagram, without its scene, which is the diagram's.
void write_cell_of_diagram(JsonWriter& out, std::uint32_t object, const Cell& cell);
std::pair<std::uint32_t, Cell> read_cell_of_diagram(JsonReader& in);

}  // namespace vcell
