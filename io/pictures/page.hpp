/// A page to look at cells: one HTML file with three.js inside that asks no network for anything.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>

#include "../../envelope/voronoi_diagram.hpp"
#include "diagram_pictures.hpp"
#include "mesh.hpp"

namespace vcell {

/// Was three.js found when the library was built? Otherwise there are no pages, and the functions below throw
/// std::logic_error.
bool has_pages();

/// The page of one cell: faces by neighbour, edges, vertices with the balls of their clearance, the base and
/// the objects, beside them the minimization diagram of write_svg() and the measures with their errors. What
/// is pointed at or chosen in one of them shows in the others.
///
/// The page's data is JSON in elements of their own: `script#scene` has the scene as scene files have it,
/// `script.cell` one cell with its numbers in full. Points of
/// meshes and of the lines of edges are single precision: `mesh.origin` plus `mesh.scale` times what is
/// written.
void write_page(std::ostream& out, const Cell& cell, const CellMesh& mesh);

/// The page of all cells of a diagram, which may be moved apart, with a table of them. Written as the cells
/// come; their meshes are larger than anything else about it.
class DiagramPage {
public:
    DiagramPage(std::ostream& out, const DiagramScene& scene);

    /// Pre: the mesh is that of the cell.
    void add(std::uint32_t object, const Cell& cell, const CellMesh& mesh);

    /// The rest of the page, after the last cell.
    void finish();

private:
    std::ostream& out_;
    const DiagramScene& scene_;
    CellColours colours_;
};

}  // namespace vcell
