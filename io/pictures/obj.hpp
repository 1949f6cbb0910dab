/// Wavefront OBJ of a cell's mesh.
#pragma once

#include <iosfwd>
#include <string>

#include "mesh.hpp"

namespace vcell {

/// Groups "face_3_object_7", "face_5_box_-x", "walls", "base", a material for each owner, smooth normals, the
/// cell's edges as polylines. `material_file` is the name to refer to; empty: no materials.
void write_obj(std::ostream& out, const Cell& cell, const CellMesh& mesh, const std::string& material_file);

/// The materials that write_obj uses, in the colours of the SVG picture.
void write_mtl(std::ostream& out, const Cell& cell);

}  // namespace vcell
