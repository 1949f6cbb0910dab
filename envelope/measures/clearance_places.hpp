/// Where a cell's clearance is least and where it is greatest.
#pragma once

#include "../cell.hpp"

namespace vcell {

/// A place of each value, on a vertex or an edge where one of these has it, else inside of a face.
///
/// Over a face clearance is stationary only where the ray from the base meets the object head on, along a
/// common perpendicular of both, and in the tips of bisectors with hollow tubes and cones; elsewhere its
/// extremes are on edges. Candidates inside of faces are in closed form, and count only where distances prove
/// it: so far before the place every object is farther than the base, and so far behind it one is nearer,
/// which bounds `error`. Places on vertices and edges carry these elements' own errors. What a candidate's
/// clearance differs by from the cell's measure, whose bound is proven, is in `clearance_error`: that a
/// better candidate was missed could make it larger, but not untrue.
///
/// None where no candidate agrees with the measure within the errors of both, where measures were not asked
/// for, and for a cell without faces.
ClearancePlaces clearance_places(const Cell& cell);

}  // namespace vcell
