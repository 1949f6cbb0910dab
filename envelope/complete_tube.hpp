/// The cell of all of the box that is nearest to a base tube that runs into sides of the box obliquely, of
/// which other objects hold whole cross sections, or whose axis is crossed by those of tubes of its radius.
///
/// Rays start on the tube's axis, between the planes across it that still meet the box. Where the axis is
/// beyond a side they come into the box through that side, whose clearance there is that of what is beyond
/// it: the same plane, seen from the other side. So between two planes of sides that the axis crosses the
/// cell has a roof and a floor as over a plane (lift/complete_lift.hpp), and the measures of its part are the
/// roof's less the floor's.
///
/// Where the axis crosses a side's plane itself, that side's clearance is 0 on one half of the directions and
/// infinite on the other one, and the ray along the plane meets it nowhere or all along. There the cell is
/// cut across the axis, in parts that keep a 2^-32th of the box's diagonal clear of these planes (AxisParts).
/// Each part has ends like the stretch of any cell around a tube (Cell::parts). What is left out counts in
/// the bounds of the measures, not in those of single faces. So it is where the axis crosses both planes
/// between it and that of a tube of the same radius, from which on the cell is on their other sides; where it
/// is as far beyond a vessel's wall as the tube is wide: from there on rays own nothing; and on both sides of
/// where it is as deep in a ball or another tube, next to which the cell ends in needles.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "../primitives/objects/decided_scene.hpp"
#include "diagram/minimization_diagram.hpp"
#include "lift/lift.hpp"

namespace vcell {

struct CompleteTube {
    LiftedCell lifted;  ///< in the decided scene's unit, with its measures if they were asked for
    EnvelopeWork work;
    SceneMoves moves;
    double unit_of_parameters = 1;  ///< of patches, in the scene's unit
    std::vector<std::string> warnings;
};

/// None if the base is no tube; or, if none holds or crosses it, where it runs along an axis of the box or
/// `is_asked` is false. Throws as voronoi_cell() does; objects must stay clear of the tube as far as its rays
/// come into the box. UndecidedError where the axis runs along a side of the box, or through one of its
/// edges, more closely than parts keep clear of planes.
std::optional<CompleteTube> lift_complete_tube(const DecidedScene& decided, bool with_measures,
                                               bool is_asked);

}  // namespace vcell
