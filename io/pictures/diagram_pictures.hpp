/// Pictures of whole diagrams, from one cell after the other as they are computed (DiagramOptions::visit).
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <unordered_map>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "mesh.hpp"

namespace vcell {

/// A colour of palette() for each cell that comes: one that none of its neighbours before it has, as long as
/// there is one. Where the box repeats neighbours are images and count for nothing.
class CellColours {
public:
    std::size_t add(std::uint32_t object, const Cell& cell);

private:
    std::unordered_map<std::uint32_t, std::size_t> of_;
};

/// Wavefront OBJ of the cells: "o cell_7_name" for each, in it groups as write_obj() has them, and
/// materials "c0" ... "c7". Both cells of a pair have the face between them, as their meshes have it.
class DiagramObj {
public:
    /// `material_file` is the name to refer to; empty: no materials.
    DiagramObj(std::ostream& out, const std::string& material_file);

    /// Pre: the mesh is that of the cell.
    void add(std::uint32_t object, const Cell& cell, const CellMesh& mesh);

    /// The materials.
    static void write_mtl(std::ostream& out);

private:
    std::ostream& out_;
    const bool has_materials_;
    std::size_t points_ = 0, normals_ = 0;
    CellColours colours_;
};

/// An SVG picture of the cells in a plane across an axis of the world, within the meshes' chord, with the
/// outlines of the balls that it cuts. Seen against the axis: of z with x to the right and y upwards, and so
/// on cyclically. Where the box repeats cells are where their balls are, and tubes that close on themselves
/// are cut wherever an image of their period is. A cell is a path of class "cell" with the object's name as
/// tooltip, and as text where there is room.
class DiagramCut {
public:
    /// Across axis 0, 1 or 2 at that coordinate.
    DiagramCut(const DiagramScene& scene, int axis, double at) : scene_(scene), axis_(axis), at_(at) {}

    /// Pre: the mesh is that of the cell, and closed.
    void add(std::uint32_t object, const Cell& cell, const CellMesh& mesh);

    void write(std::ostream& out) const;

private:
    using Polygon = std::vector<Vec2>;
    struct Section {
        std::uint32_t object;
        std::size_t colour;
        std::vector<Polygon> polygons;
    };

    /// Zero, or after what way a tube closes on itself.
    Vec3 period_of(std::uint32_t object) const;
    /// What the mesh has at a coordinate, moved.
    void add_section(const CellMesh& mesh, double at, const Vec3& by, Section& section) const;
    Vec2 in_picture(const Vec3& p) const { return {p[(axis_ + 1) % 3], p[(axis_ + 2) % 3]}; }

    const DiagramScene& scene_;
    const int axis_;
    const double at_;
    std::vector<Section> sections_;
    CellColours colours_;
};

}  // namespace vcell
