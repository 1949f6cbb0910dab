/// Sectors once around an axis: which of them a point lies in.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <ranges>

#include "../../core/platform.hpp"

namespace vcell {

/// The sector that a point is least outside of. `starts`: the angles at which sectors begin, two or more,
/// ascending, each sector up to the next one and the last one up to the first, a whole turn on. `half`: half
/// the angle from the middle of the first one to the point, between -pi/2 and pi/2. Strips next to each other
/// do as well, with lengths, where nothing is beyond the outer ones. Angles are rounded:
/// outside(i), how far the point is outside of sector i, decides between the sector found and the two beside
/// it.
template <std::ranges::random_access_range Starts, class Outside>
std::uint32_t sector_around(const Starts& starts, double half, Outside&& outside) {
    const std::size_t n = std::ranges::size(starts);
    double angle = 0.5 * (starts[0] + starts[1]) + 2 * half;
    if (angle < starts[0]) angle += 2 * std::numbers::pi;
    const auto after = std::ranges::upper_bound(starts, angle) - std::ranges::begin(starts);
    const std::size_t at = std::max<std::size_t>(1, static_cast<std::size_t>(after)) - 1;
    std::size_t best = at;
    double least = outside(at);
    for (const std::size_t i : {(at + n - 1) % n, (at + 1) % n})
        if (const double off = outside(i); off < least) {
            best = i;
            least = off;
        }
    return static_cast<std::uint32_t>(best);
}

}  // namespace vcell
