/// Edges: all along a curve the excesses of its two sites are within its error of zero (edge_distance.cpp),
/// and no third site is nearer (edge_rivals.cpp).
#pragma once

#include <vector>

#include "room.hpp"

namespace vcell::check {

/// How well a curve is known to follow the true arc.
struct EdgeBound {
    double distance = HUGE_VAL;  ///< from it; where the bisectors touch, from the boundary
    double rounded = 0;          ///< how far off are excesses that are no difference (Room::tie_width)
    double excess = HUGE_VAL;    ///< of its two sites
    double growth = 0;           ///< of those towards the base, per length (Room::growth)
};

/// Sets the bounds, by edge of the cell, of those that are proved. Pre: there is one for each edge.
void certify_edges(const Subject& subject, const CheckOptions& options, Certificate& certificate,
                   std::vector<EdgeBound>& bounds);

}  // namespace vcell::check
