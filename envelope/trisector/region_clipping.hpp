/// What of a trisector's curves lies in a region, and outside the three solids.
#pragma once

#include <array>
#include <vector>

#include "uncut_curves.hpp"

namespace vcell {

/// Between two parameters of a curve. Where it is cut its point is `off` from the true one at most. It ends
/// on a side of the region, or with -1 in a node, or where the surfaces of all three meet.
struct CurvePart {
    double from, to;
    std::array<int, 2> ends;
    double off;
};

/// For each curve its parts, in order. All crossings with the sides of the region, and with all three
/// surfaces at once, are roots of a vertex's equations (core/solver/roots), each of them proved.
/// Throws UndecidedError where a crossing is none that is told, or on no curve or several.
std::vector<std::vector<CurvePart>> parts_within(const SolidCurves& all, const Box& region);

}  // namespace vcell
