/// A cell in a file of any format, told by its ending.
#pragma once

#include <string>

#include "mesh.hpp"

namespace vcell {

/// The ending of a path without its dot, in small letters: "step" of .stp, and "bezier.vtu" of both.
std::string format_of(const std::string& path);

/// Writes the cell in the format of the path's ending: .json, .svg, .html, .obj, .stl, .ply, .vtu,
/// .bezier.vtu, .glb, .3mf, .step or .itd, as write_cell() and the others write it; a .obj without materials.
/// Formats of
/// triangles take the cell's `mesh`, or without it tessellate(cell). The file is complete or untouched
/// (OutputFile).
/// Throws std::invalid_argument for other endings, and for .html where three.js was missing when vcell was
/// built; WriteError; and what the formats' own functions throw.
void write_file(const std::string& path, const Cell& cell);
void write_file(const std::string& path, const Cell& cell, const CellMesh& mesh);

}  // namespace vcell
