/// Triangles of a mesh that lie on each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "mesh.hpp"

namespace vcell {

/// The points of a triangulation in space, and the patch's unit normals there.
struct PlacedPoints {
    std::vector<Vec3> places, normals;
    /// The area of triangles that are turned over all the same, and those of their corners that are the
    /// polygon's: its sides there are too long.
    double folded = 0;
    std::vector<std::uint32_t> at_folds;
};
/// Places t's points, which are parameters of the patch, and moves those inside the polygon that turn a
/// triangle over. Such a point is beyond a side of the polygon in space, as far as the side's chord allows;
/// it moves towards the middle of its neighbours until none of its triangles is turned over, or stays where
/// no place on the way is better. Pairs of triangles of which some are turned over then take the other
/// diagonal, where that leaves less of them so, and sides of those that are left are halved, where that does.
/// `polygon`: where the polygon's points are in space, the first ones of t; `doubt`: how far they may be off
/// the patch, length, rounding included: a triangle that is no wider is left as it is.
PlacedPoints place_without_folds(const RationalPatch& s, std::vector<Vec3> polygon, double doubt,
                                 Triangulation& t);

/// A patch's triangles in a mesh, which may change.
struct DrawnPatch {
    std::size_t begin, end;
    const RationalPatch* surface;
    /// The patch's points, of which normals follow each other from `first_normal` on.
    std::vector<Vec2> parameters;
    std::uint32_t first_normal;
    std::span<const MeshSide> taken;  ///< KnownMesh::taken of its face
};

/// Where faces on both sides of a line cut off the same corner of it, one side in space is two of the mesh:
/// one of the two faces takes the other diagonal there. So does a face of sides that are taken. Where the
/// other diagonal is a side, too, or would turn a triangle over, a point divides the side.
void separate_sides(CellMesh& mesh, std::vector<DrawnPatch>& drawn);

}  // namespace vcell
