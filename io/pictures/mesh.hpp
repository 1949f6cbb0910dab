/// A triangle mesh of a cell's boundary: one tessellation for all mesh formats.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "../../envelope/cell.hpp"
#include "triangulate.hpp"

namespace vcell {

/// Two points of a mesh, ascending.
using MeshSide = std::array<std::uint32_t, 2>;

/// Where a chord is too fine it grows by this factor, once or more often.
inline constexpr double chord_step = 4;

struct MeshOptions {
    /// The largest distance, in length, between a triangle's side and the surface, along its normal, or the
    /// edge, measured at the side's middle. None: a thousandth of cell_diagonal().
    std::optional<double> chord;
    /// The mesh of the whole solid, the base's own body included. Over a plane base: with walls under the rim
    /// and the base region as floor; over a cylinder base with both ends as walls; over a sphere base the
    /// same as without.
    bool closed = false;
    /// No mesh has more triangles: where the chord would take more, or more than 4096 pieces of an edge, it
    /// grows until it does not. None: so it grows where there would be more than usually_most, or until none
    /// is cut for its sake any more, and only the cell's edges ask for them.
    std::optional<std::size_t> most_triangles = std::nullopt;
    static constexpr std::size_t usually_most = 1'000'000;
    /// No chord of a face or an edge is more than this part of the diagonal of the smallest axis-parallel box
    /// about it, to a few percent.
    double most_of_own = std::numeric_limits<double>::infinity();
};

/// More triangles are needed than were asked for, however large the chord is.
struct TooManyTriangles : std::invalid_argument {
    TooManyTriangles(std::size_t most, std::size_t there_are);
};

struct CellMesh {
    struct Group {
        enum class Kind : std::uint8_t { Face, Walls, Base };
        Kind kind;
        std::uint32_t face;      ///< Face: index into Cell::faces
        std::size_t begin, end;  ///< range of triangles
        /// Face: whose it is, as the cell names it, or in meshes of ConformingMeshes the diagram: images have
        /// the numbers of their objects.
        Site site = Site::base();
    };

    double chord =
        0;  ///< that the triangles keep, length: larger than asked for where most_triangles was met
    std::vector<Vec3> points;
    std::vector<Vec3> normals;             ///< unit, out of the cell
    std::vector<Triangle> triangles;       ///< into points, counter-clockwise seen from outside
    std::vector<Triangle> corner_normals;  ///< into normals, corner by corner
    std::vector<Group> groups;
    /// For each cell edge, into points; empty of ends of parts that are joined (JoinedParts).
    std::vector<std::vector<std::uint32_t>> edge_lines;
};

/// The diagonal of the smallest axis-parallel box about the base (a plane's region, a cylinder's stretch) and
/// the cell's edges and seams, to a few percent: the size of a picture of the cell, however large its box is.
double cell_diagonal(const Cell& cell);

/// Every edge of the cell is sampled once and both of its faces share these points, so the mesh has no
/// cracks: each of its sides belongs to two triangles, or to one on the rim if it is not closed. So is every
/// seam between a face's patches, and every end of a tube's part that joined_parts() joins to the next one.
/// Sampling is refined until no two sides of a face cross. Pre: patches are
/// oriented like the chart. Throws TooManyTriangles; InternalError for a cell whose rim does not close.
CellMesh tessellate(const Cell& cell, const MeshOptions& options = {});

}  // namespace vcell
