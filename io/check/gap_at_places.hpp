/// How far a trimming curve, lifted to its patch, is from its edge: by values at some places.
#pragma once

#include "trim_pair.hpp"

namespace vcell::check {

/// Bounds |S(c(t)) - C(t)| by its values at as many places as it has coefficients, or about twice as
/// many. Infinite where the curve runs far beside the patch, degrees are none of the usual ones, or so
/// low that many places tell no more.
double gap_at_places(const NetOver& over, const TrimPair& pair, bool are_many);

}  // namespace vcell::check
