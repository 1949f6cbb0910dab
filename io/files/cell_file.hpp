/// Cell files: a cell as JSON (docs/files.md, "Cell"). A reader needs neither the scene file nor this
/// program.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>

#include "../../envelope/cell.hpp"

namespace vcell {

/// Every double reads back as itself. The sites that coincide with an owner all along an edge or all over
/// a face are listed under "extra_sites", where there are any. "closing" has cell.closing, or where there is
/// none closing_of() the cell, unless nothing closes it. The bytes are the same for any number of threads; 0:
/// as many as the machine has cores. Throws InternalError where a number is not finite: of cells that are not
/// measured (CellOptions::measure); and as closing_of() does.
void write_cell(std::ostream& out, const Cell& cell, unsigned threads = 1);

/// The cell of a file's text. Keys, types and shapes are checked, and the scene is validated; values are
/// not judged. A cell from an unknown hand is safe to evaluate once check_cell finds nothing wrong.
/// Throws InputError with the JSON path of the first offender.
Cell parse_cell(std::string_view text);

/// parse_cell() of what is a cell file, or none: of what is no JSON with a scene in it.
std::optional<Cell> parse_if_cell(std::string_view text);

/// parse_cell of a file, of standard input for "-". Throws ReadError, InputError.
Cell read_cell(const std::string& path);

}  // namespace vcell
