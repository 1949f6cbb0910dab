/// All of the boundary of the solid that a cell is, with what closes it: walls, floor, ends.
#pragma once

#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

/// The cell's elements with their numbers, and after them those that close the solid, the base's own body
/// included. Around a ball there are none. Over a plane there are walls under the rim along the base's
/// normals, and the base's region; around a tube the flat ends of its stretch. Their faces have one patch
/// each, bilinear over a rectangle of lengths: origin + u x + v y, with orthogonal unit vectors x and y, and
/// x cross y out of the solid. A face's `site` is the side of the box or the end where it lies, or the base;
/// its `bisector` is "wall", "end" or "base". Lengths and areas of all of these are not_measured.
struct Shell {
    std::vector<CellVertex> vertices;  ///< further ones: the feet of the rim's corners on the base
    std::vector<CellEdge> edges;       ///< further ones: straight, from foot to corner and between feet
    std::vector<CellFace> faces;       ///< walls by site, ends, and the base's region in the end
    /// Bounds the distance of an edge's curve from the plane of a wall, an end or the base that ends there.
    double off_plane = 0;
};

/// Every edge is used once each way, by all loops together, where a seam cuts it in parts. Where a corner of
/// the rim is no higher over a base plane than its error, it is its own foot: a wall ends in it without a
/// line upwards; and where the box ends on the base (both sites of the edge are the side there) there is no
/// wall. Throws InternalError for a cell whose rim does not close.
Shell closed_shell(const Cell& cell);

}  // namespace vcell
