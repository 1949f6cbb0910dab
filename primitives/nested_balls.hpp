/// Balls within balls, by exact signs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base_problem.hpp"

namespace vcell {

/// For each ball another one in which it lies (touching it from within included), or UINT32_MAX.
/// Nested balls of ordinary scenes take O(n log n): a tree over the centres, pruned by the largest radii.
/// Pre: no two balls are equal.
std::vector<std::uint32_t> enclosing_balls(std::span<const Ball> balls);

}  // namespace vcell
