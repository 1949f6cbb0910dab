/// Objects as triangles, for pictures.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "../../primitives/objects/objects.hpp"

namespace vcell {

/// Of a surface: a point, and the unit normal there.
struct Corner {
    Vec3 point, normal;
};
using CornerTriangle = std::array<Corner, 3>;

/// What of the triangles lies on the sides that the planes' normals point to.
std::vector<CornerTriangle> clipped(std::span<const CornerTriangle> triangles, std::span<const Plane> planes);

/// The planes of the sides of a box, their normals inwards.
std::array<Plane, 6> sides_of(const Box& box);

/// The object's surface: a whole sphere, and what the box leaves of a plane and of a cylinder; within a
/// hundredth of a radius.
std::vector<CornerTriangle> surface_of(const Object& object, const Box& box);

}  // namespace vcell
