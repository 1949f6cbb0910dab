/// Triangles with labels, as mesh viewers and slicers read them: STL, PLY, VTK's .vtu, binary glTF and 3MF,
/// of one cell or of all cells of a diagram.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh.hpp"

namespace vcell {

/// Meshes side by side, each closed by itself: no points are shared.
struct LabelledMesh {
    /// What is no object on the other side of a triangle: a side of the box, as -1 - Site::index; the base or
    /// its walls and ends.
    static constexpr std::int32_t beside_base = -7;
    static std::int32_t label(Site site);

    std::vector<Vec3> points;
    std::vector<double> clearance;  ///< of the points: their distance from the cell's base
    std::vector<Triangle> triangles;
    /// Of the triangles: whose cell, by its number (-1: the base of a scene that does not number it), and
    /// what is beyond.
    std::vector<std::int32_t> cell, neighbor;
    std::vector<Vec3> normals;             ///< unit, out of the cells
    std::vector<Triangle> corner_normals;  ///< into normals, corner by corner

    struct Material {
        std::string name;
        std::string_view colour;  ///< "#rrggbb"
    };
    std::vector<Material> materials;
    struct Range {
        std::size_t begin, end;
    };
    /// Triangles of one look: a cell's face, its walls or its base, or all of a cell.
    struct Face {
        Range triangles;
        std::size_t material;
    };
    std::vector<Face> faces;
    std::vector<std::vector<std::uint32_t>> lines;  ///< edges, into points
    struct Part {
        std::int32_t cell;
        std::string title;  ///< "cell 7 (O1)"
        Range points, triangles, faces, lines;
    };
    std::vector<Part> parts;  ///< one for each cell
    struct Numbers {
        std::string name;
        std::vector<double> of_parts;  ///< one for each
    };
    std::vector<Numbers> numbers;  ///< of cells, as cell data of a .vtu
    std::string units;             ///< of the scene

    /// Appends a cell's mesh. Sites are numbers of objects, as the cell has them. `colour` is the place in
    /// palette() that all of it has; without one its faces have the colours of their neighbours, and its
    /// edges are lines.
    void add(std::int32_t number, const Cell& cell, const CellMesh& mesh,
             std::optional<std::size_t> colour = std::nullopt);

private:
    std::size_t material(const std::string& name, std::string_view colour);
};

/// Binary STL: single precision, no labels. Pre: fewer than 2^32 triangles.
void write_stl(std::ostream& out, const LabelledMesh& mesh);

/// Binary little-endian PLY: vertices with x, y, z and clearance, faces with cell and neighbor.
void write_ply(std::ostream& out, const LabelledMesh& mesh);

/// VTK XML unstructured grid, arrays in base64: triangles with cell and neighbor, points with clearance.
void write_vtu(std::ostream& out, const LabelledMesh& mesh);

/// Binary glTF 2.0: a node for each part, about whose middle coordinates are in single precision; in it a
/// primitive with smooth normals for each face and a strip for each line. A unit of the scene is one of
/// glTF's, and the scene's z is upwards. Throws WriteError for what does not fit into 4 GB.
void write_glb(std::ostream& out, const LabelledMesh& mesh);

/// 3MF core: an object for each part, "surface" unless it is closed, materials by triangle. Units that the
/// format does not know are called millimeters. Throws WriteError as write_glb() does.
void write_3mf(std::ostream& out, const LabelledMesh& mesh);

/// Is it the name of one of these formats: "stl", "ply", "vtu", "glb" or "3mf"?
bool is_mesh_format(std::string_view name);

/// Pre: is_mesh_format(format).
void write_mesh(std::ostream& out, std::string_view format, const LabelledMesh& mesh);

}  // namespace vcell
