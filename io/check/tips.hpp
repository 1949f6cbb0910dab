/// Where bisectors with hollow tubes and cones, and with tubes that pierce the base, have tips.
#pragma once

#include <span>
#include <vector>

#include "space.hpp"

namespace vcell::check {

/// A point of the object's axis that is as far from the base as from the vessel's wall, or the tube's
/// surface.
struct Tip {
    Vector<Interval> p;
    Interval reach;  ///< from the base's plane, centre or axis
};

/// The tips there may be, nearer to the apex or lower along the axis first; none where there certainly is
/// none, and none of other objects. Over a plane there is one at most. Where the axis leans from the base's
/// as much as the wall does, those that cannot be told are left out: over a plane those of level tubes.
std::vector<Tip> tips_of(const Space<Interval>& space, const Object& object);

/// How far any point of a box is from the tip that is nearest to all of them, at most; infinite without tips.
double farthest_from(std::span<const Tip> tips, const Vector<Interval>& box);

}  // namespace vcell::check
