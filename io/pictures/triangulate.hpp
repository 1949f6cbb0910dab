/// Triangles inside a polygon, for pictures of curved faces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace vcell {

using Triangle = std::array<std::uint32_t, 3>;

struct Triangulation {
    /// The polygon's vertices, loop after loop as given, then the vertices added inside.
    std::vector<Eigen::Vector2d> points;
    std::vector<Triangle> triangles;  ///< counter-clockwise
};

/// Triangulates a polygon: `loops[0]` runs counter-clockwise around it, the others clockwise around its
/// holes; none crosses itself or another. Sides of the polygon are kept whole, so polygons that share sides
/// fit together. Where `split(a, b)` says so, inner edges are halved until it no longer does; where it
/// would not let the polygon's sides be either, that may never be, and a bound on the points ends it, or
/// `most_points`, if the polygon has not got more. The
/// triangles are as round as the vertices allow (Delaunay flips).
///
/// Floating point throughout, for looks; but every side belongs to exactly one triangle and every other edge
/// to two whatever the coordinates are. Vertices of different loops, or met twice by one, are different
/// vertices even where they coincide.
Triangulation triangulate(const std::vector<std::vector<Eigen::Vector2d>>& loops,
                          const std::function<bool(const Eigen::Vector2d&, const Eigen::Vector2d&)>& split,
                          std::size_t most_points = SIZE_MAX);

}  // namespace vcell
