/// Where cells of tubes end in parts, for others that share edges with them.
#pragma once

#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/objects/objects.hpp"
#include "../../primitives/objects/scene.hpp"

namespace vcell {

/// The planes across a tube's axis where that meets the plane of a side of the box, in order along it: there
/// parts of its complete cell end (Cell::parts), but for half a slab. None of what is no tube, or runs
/// along an axis of the box.
std::vector<Plane> part_ends(const Object& object, const Box& box);

/// Appends where a curve crosses a plane, parameters inside its domain, ascending: one for each change of
/// sides between an eighth of a span and the next one.
void add_crossings(const RationalCurve3& curve, const Plane& plane, std::vector<double>& parameters);

}  // namespace vcell
