/// Where a span's trims lie: on which parts of the patches, and where it crosses a seam between them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "space_equation.hpp"
#include "space_tube.hpp"

namespace vcell::space_fit {

struct Trims {
    std::array<std::uint32_t, 2> part{};
    Patches patches{};           // of those parts
    std::optional<Linear> seam;  // crossed: then there are no trims
};

// Chooses the parts and puts the trims below the curve, whose rows of `points` are given.
Trims place_trims(const SpaceArc& arc, double tolerance, Points& points);

// Where a linear function vanishes on a span, if it is seen to change its sign.
std::optional<Vector4d> sign_change(const Points& points, const Linear& f, double tolerance);

}  // namespace vcell::space_fit
