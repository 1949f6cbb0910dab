/// Triangles of a mesh that lie on each other.
#pragma once

#include <cstddef>
#include <utility>
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

/// Where faces on both sides of a line cut off the same corner of it, one side in space is two of the mesh:
/// one of the two faces takes the other diagonal there. `drawn`: ranges of triangles, each of one patch, that
/// may change.
void separate_sides(CellMesh& mesh, const std::vector<std::pair<std::size_t, std::size_t>>& drawn);

}  // namespace vcell
