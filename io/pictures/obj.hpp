/// Wavefront OBJ of a cell's mesh.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>

#include "mesh.hpp"

namespace vcell {

/// Groups "face_3_object_7", "face_5_box_-x", "walls", "base", a material for each owner, smooth normals, the
/// cell's edges as polylines. `material_file` is the name to refer to; empty: no materials.
void write_obj(std::ostream& out, const Cell& cell, const CellMesh& mesh, const std::string& material_file);

/// What else is in the file.
struct ObjPart {
    std::size_t points = 0, normals = 0;  ///< before this mesh
    std::string material;                 ///< of all of it; empty: none
};
/// Points, normals and triangles alone, in write_obj()'s groups.
void write_obj_mesh(std::ostream& out, const CellMesh& mesh, const ObjPart& part);

/// One material of a colour "#rrggbb".
void write_material(std::ostream& out, const std::string& name, std::string_view colour);

/// The materials that write_obj uses, in the colours of the SVG picture.
void write_mtl(std::ostream& out, const Cell& cell);

}  // namespace vcell
