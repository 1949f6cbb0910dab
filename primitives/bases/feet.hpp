/// Where the rays of a base start that come through a region of space.
#pragma once

#include "../objects/objects.hpp"

namespace vcell {

/// The point of the base whose ray p is on: of a plane, of a cylinder's axis, or a sphere's centre. Rounded.
Vec3 foot_of(const Object& base, const Vec3& p);

/// A point on the base's own side of it, where it has two sides.
Vec3 beside(const Object& base);

/// A box that holds a region and the feet of all of its points, so that the part of the base in it has the
/// rays of all of them, rounding included. A side of it is one of the region's where that has the feet on its
/// inner side; otherwise a sixteenth of the region's diagonal beyond them, and beyond a tube's circles about
/// them where the tube runs into sides obliquely.
Box box_with_feet(const Object& base, const Box& region);

}  // namespace vcell
