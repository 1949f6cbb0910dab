/// Edges: all along a curve the excesses of its two sites are within its error of zero, and no third site is
/// nearer.
///
/// The excesses of two sites are a map f of space to the plane. Where the least singular value of its
/// derivative is at least s, all within |f| / s of a point, there is a zero that close: the flow of Newton's
/// method, x' = -J^+ f, leads there on a path no longer than that [Deuflhard04, 3.3].
#pragma once

#include <vector>

#include "room.hpp"

namespace vcell::check {

/// How well a curve is known to follow the true arc.
struct EdgeBound {
    double distance = HUGE_VAL;  ///< from it; where the bisectors touch, from the boundary
    double excess = HUGE_VAL;    ///< of its two sites
    double growth = 0;           ///< of those towards the base, per length (Room::growth)
};

/// Sets the bounds, by edge of the cell, of those that are proved. Pre: there is one for each edge.
void certify_edges(const Subject& subject, const CheckOptions& options, Certificate& certificate,
                   std::vector<EdgeBound>& bounds);

}  // namespace vcell::check
