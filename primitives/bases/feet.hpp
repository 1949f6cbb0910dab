/// Where the rays of a base start that come through a region of space.
#pragma once

#include <span>
#include <vector>

#include "../objects/objects.hpp"

namespace vcell {

/// The point of the base whose ray p is on: of a plane, of a cylinder's axis, or a sphere's centre. Rounded.
Vec3 foot_of(const Object& base, const Vec3& p);

/// A point on the base's own side of it, where it has two sides.
Vec3 beside(const Object& base);

/// A plane with its normal to the other side; what has one side alone as it is.
Object turned_over(const Object& object);
/// A plane with its normal to the side on which p is, likewise; that is rounded.
Object seen_from(const Object& object, const Vec3& p);

/// The base from each of its sides from which it may be as far as from all of the others: a plane that none
/// of them cuts has the others on one side, and what is wholly in front of it is nearest to nothing behind
/// it.
std::vector<Object> sides_to_look_from(const Object& base, std::span<const Object> others);

/// A box that holds a region and the feet of all of its points, so that the part of the base in it has the
/// rays of all of them, rounding included. A side of it is one of the region's where that has the feet on its
/// inner side; otherwise a sixteenth of the region's diagonal beyond them, and beyond a tube's circles about
/// them where the tube runs into sides obliquely.
Box box_with_feet(const Object& base, const Box& region);

}  // namespace vcell
