/// Polygons of mesh points in a plane.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "../../primitives/objects/objects.hpp"
#include "triangulate.hpp"

namespace vcell {

/// One point of a face's polygon.
struct LoopPoint {
    std::uint32_t point;  ///< of the mesh
    Vec2 uv;
    std::uint32_t line;   ///< the edge or seam that starts or goes on here
    std::uint32_t piece;  ///< of the line as it was sampled, from here to the next point
};

/// Do the segments from a to b and from c to d cross, each inside the other's ends? Plain doubles.
bool proper_crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);

/// Lines that have a side that crosses another one of these polygons, in no order and some more than once.
std::vector<std::uint32_t> crossing_lines(const std::vector<std::vector<LoopPoint>>& polygons);

/// Polygons that run counter-clockwise, each followed by those in it that run clockwise. Pre: no two cross.
std::vector<std::vector<std::vector<LoopPoint>>> with_holes(std::vector<std::vector<LoopPoint>> polygons);

}  // namespace vcell
