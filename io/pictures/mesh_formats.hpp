/// Triangles with labels, as mesh viewers and slicers read them: STL, PLY and VTK's .vtu, of one cell or of
/// all cells of a diagram.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string_view>
#include <vector>

#include "mesh.hpp"

namespace vcell {

/// Meshes side by side, each closed by itself: no points are shared.
struct LabelledMesh {
    /// What is no object on the other side of a triangle: a side of the box, as -1 - Site::index; the base or
    /// its walls and ends.
    static constexpr std::int32_t beside_base = -7;

    std::vector<Vec3> points;
    std::vector<double> clearance;  ///< of the points: their distance from the cell's base
    std::vector<Triangle> triangles;
    /// Of the triangles: whose cell, by its number (-1: the base of a scene that does not number it), and
    /// what is beyond.
    std::vector<std::int32_t> cell, neighbor;

    /// Appends a cell's mesh. Sites are numbers of objects, as the cell has them.
    void add(std::int32_t number, const Cell& cell, const CellMesh& mesh);
};

/// Binary STL: single precision, no labels. Pre: fewer than 2^32 triangles.
void write_stl(std::ostream& out, const LabelledMesh& mesh);

/// Binary little-endian PLY: vertices with x, y, z and clearance, faces with cell and neighbor.
void write_ply(std::ostream& out, const LabelledMesh& mesh);

/// VTK XML unstructured grid, arrays in base64: triangles with cell and neighbor, points with clearance.
void write_vtu(std::ostream& out, const LabelledMesh& mesh);

/// One of these by its name: "stl", "ply" or "vtu".
void write_mesh(std::ostream& out, std::string_view format, const LabelledMesh& mesh);

}  // namespace vcell
