/// Meshes of a diagram's cells that fit together: what two cells share is drawn once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "mesh.hpp"

namespace vcell {

namespace shared {
class Store;
struct Additions;
}  // namespace shared
namespace whole {
class DecidedDiagram;
}

/// The meshes of a diagram's cells, closed, one after the other as they are computed (DiagramOptions::visit).
/// The face between two cells is the same triangles in both, turned around, an edge is one polyline in all
/// cells that have it, and a vertex is one point: the first cell draws them, the others take them over,
/// number for number. Where the box repeats and the other cell is that of an image, points are moved by what
/// that is away, and are the same but for the rounding of this sum.
///
/// Vertices are the same if three of their sites are and their errors do not tell them apart, edges if their
/// ends are, and two sites, and a point of one lies on the other within their errors, faces if all of their
/// edges are: nothing is joined for being near alone. Cells of tubes, which
/// come in parts, are joined (joined_parts()), and their edges and faces go on beyond the ends of parts;
/// others have a point on their edges there. What is not found so the cell draws for itself; its mesh is
/// closed all the same. So it is where parts are not joined, and where cells are of different opinions about
/// what is a vertex.
///
/// A chord is the part `chord` of the diagonal of the cell that is drawn first, but no more than 2.5 times
/// that part of the face's or the edge's own: so a large cell's face is fine enough for a small one beyond.
/// Chords of edges that other cells have drawn are not refined, even where they cross: triangles may overlap
/// there.
///
/// A part is kept until the last cell has come that may have it: of objects that are listed as they lie,
/// layer by layer, that is one layer's, of others up to half of all.
class ConformingMeshes {
public:
    /// Pre: chord > 0. Throws as voronoi_diagram().
    explicit ConformingMeshes(const DiagramScene& scene, double chord = 0.002);
    ~ConformingMeshes();
    ConformingMeshes(const ConformingMeshes&) = delete;
    ConformingMeshes& operator=(const ConformingMeshes&) = delete;

    /// The mesh of a cell that is not kept. Pre: the cell is one that DiagramOptions::visit has of the
    /// scene's diagram; objects do not descend from call to call. Throws as tessellate().
    CellMesh add(std::uint32_t object, const Cell& cell);

    /// Does what add() does unless the cell has more triangles than that with its chord, or an edge more than
    /// 4096 pieces: then there is no mesh, and no further cells are to be added. (add() lets the chord of a
    /// cell grow that has more than a million.)
    std::optional<CellMesh> add_within(std::uint32_t object, const Cell& cell, std::size_t most_triangles);

    /// Faces so far that a cell has drawn although the cell beyond had come before.
    std::size_t drawn_again() const;

private:
    CellMesh draw(std::uint32_t object, const Cell& cell, std::optional<std::size_t> most_triangles);

    std::unique_ptr<shared::Store> store_;
    double chord_;
    std::uint32_t passed_ = 0;  // cells of lower objects come no more
};

/// ConformingMeshes of cells that are drawn in several places: what one leaves for others the others learn.
/// Cells that have nothing in common may come in any order.
class ScatteredMeshes {
public:
    /// The diagram has so many objects; `decided` are some of them, all that are no balls among these. Pre:
    /// chord > 0.
    ScatteredMeshes(const whole::DecidedDiagram& decided, std::size_t objects, double chord = 0.002);
    ~ScatteredMeshes();
    ScatteredMeshes(const ScatteredMeshes&) = delete;
    ScatteredMeshes& operator=(const ScatteredMeshes&) = delete;

    /// The meshes of all cells of an object, as ConformingMeshes::add() has them. Pre: of the objects of
    /// lower numbers that it meets (objects_met()), or that meet it, all cells have been added or learned,
    /// and of those of higher numbers none.
    std::vector<CellMesh> add(std::uint32_t object, std::span<const Cell> cells);
    /// What the last add() has left for the objects that meet in the cell, and for those that meet it.
    shared::Additions take_additions();
    /// Takes over additions that were taken from another one, as if their cell had been added here. Pre: that
    /// of add().
    void learn(const shared::Additions& additions);

private:
    std::unique_ptr<shared::Store> store_;
    double chord_;
};

/// The diagram's objects that a cell lists, ascending.
std::vector<std::uint32_t> objects_met(const Cell& cell);

}  // namespace vcell
