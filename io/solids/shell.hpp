/// All of the boundary of the solid that a cell is, with what closes it: walls, floor, ends.
#pragma once

#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

/// What closes the cell to a solid. Around a ball there is nothing in it. Over a plane there are walls under
/// the rim along the base's normals, and the base's region; around a tube the flat ends of its stretch.
///
/// Vertices: the feet of the rim's corners on the base. Edges: straight, from foot to corner and between
/// feet. Faces: walls by site, ends, and the base's region in the end, with one patch each, bilinear over a
/// rectangle of lengths: origin + u x + v y, with orthogonal unit vectors x and y, and x cross y out of the
/// solid. Their trims have the knots and weights of their edges' curves. A face's `site` is the side of the
/// box or the end where it lies, or the base; its `bisector` is "wall", "end" or "base".
///
/// With it every edge is used once each way, by all loops together, where a seam cuts it in parts. Where a
/// corner of the rim is no higher over a base plane than its error, it is its own foot: a wall ends in it
/// without a line upwards; and where the box ends on the base (an edge of the rim lies on it, or both its
/// sites are the side there) there is no wall. Throws InternalError for a cell whose rim does not close.
Closing closing_of(const Cell& cell);

/// The cell's elements with their numbers, and after them those of closing_of().
struct Shell {
    std::vector<CellVertex> vertices;
    std::vector<CellEdge> edges;
    std::vector<CellFace> faces;
    /// Bounds the distance of an edge's curve from the plane of a wall, an end or the base that ends there.
    double off_plane = 0;
};

/// Throws as closing_of() does.
Shell closed_shell(const Cell& cell);

}  // namespace vcell
