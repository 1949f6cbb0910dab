/// The lines of points that are equally far from three planes, within a box.
#pragma once

#include <vector>

#include "trisector_curves.hpp"
#include "uncut_curves.hpp"

namespace vcell {

/// The lines lie outside three half spaces and are equally far from all. They need no base: they solve linear
/// equations (primitives/bisectors/trisector.hpp), and how far their doubles are from them is told by the
/// equations' values there. Throws UndecidedError where a line runs along a side of the region, or touches an
/// edge of it, and where planes are so nearly parallel that its error exceeds 256 tolerances.
std::vector<TrisectorCurve> lines_between_planes(const Solids& planes, const Box& region, double tolerance);

}  // namespace vcell
