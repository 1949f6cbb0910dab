/// Over a cylinder: which of three planes through one line is nowhere the nearest one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "radial_form.hpp"

namespace vcell {

/// The forms f of walls, planes that bound the cell themselves, are proportional to what is left of the way
/// inwards, C - 2 t B, which is linear in their coefficients. So f_m = a f_1 + b f_2 with a, b > 0 is
/// positive wherever both others are, and 0 only where these are: on the line that all three have in common,
/// an edge of the box, say. Where places are rounded, as in nets whose meshes are no binary fractions, f_m
/// comes out beside that sum, and next to the line nearer by parts of 2^-53: so it gives way.
struct WallTie {
    std::uint32_t middle;
    std::uint32_t first, second;  ///< by their places in the list
    /// 0: exact; otherwise a bound on how far from both others' planes it is that the middle one is nearer.
    double off;

    bool operator==(const WallTie&) const = default;
};

/// All ties of that kind, exact or of walls that give way by `most` at most. `reach`: bounds the distance of
/// all places from the origin. Those of walls that are next to parallel may be missed. Takes as long as
/// sorting all pairs.
std::vector<WallTie> find_wall_ties(std::span<const RadialForm> walls, double reach, double most);

}  // namespace vcell
