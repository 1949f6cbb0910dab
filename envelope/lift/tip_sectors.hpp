/// Sectors about an object's axis for a face on both sides of a tip over a cylinder base.
///
/// Patches about the tip (RadialPatch::around_tip()) are for one half of all directions each, about the lines
/// through the tip. In a vessel such a line runs on to where the base's axis comes out of the wall, and
/// another line from there on, in the same half plane, which takes the patch of the other half. The face has
/// parts next to both lines where it reaches around the base. A sector that holds both lines then has two
/// patches, and is as narrow as keeps the face apart between its parts there; those beside it, in which the
/// parts come together, take the patch for what is beyond: the other one has no finite point beyond some v,
/// which differs from angle to angle, and this one is good from the tip on, which all angles have in common.
///
/// *They are apart*: a plane through the base's axis lies between both lines. What is nearer to the base than
/// to the wall is convex, as the distance from the base is a convex function and that from a wall around one
/// a concave function; so over each half of the plane the bisector is a conic's arc from the point where the
/// axis comes out, where it meets the half plane of the lines, and nowhere else. A pencil of planes about the
/// object's axis meets the arc twice at most: the angle grows along it up to some point, and from there on
/// falls. Over a stretch of the base it is the smallest at an end.
#pragma once

#include <vector>

#include "based_diagram.hpp"
#include "cylinder_turns.hpp"
#include "object_turns.hpp"

namespace vcell::radial {

/// From one angle of an axis to another one; of strips, from one length to another one.
struct SectorRange {
    double from, to;
    bool is_beyond = false;  ///< it takes the patch of the other half
    /// Not 0: there are two sectors, one next to the tip, where the product with a point is positive, and one
    /// beyond.
    Vec3 inwards = Vec3::Zero();
};

/// Once around. `extent`: the face's. Throws UndecidedError where a part beside the base's end is too close
/// to that.
std::vector<SectorRange> tip_sectors(const RadialDiagram& of, FormId form, const BisectorTip& tip,
                                     const ObjectAxis& axis, const CylinderTurns& turns,
                                     const CylinderTurns::Extent& extent);

}  // namespace vcell::radial
