/// Balls within balls, by exact signs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "canonical.hpp"

namespace vcell {

/// Which of several balls say nothing of their own.
struct BallNesting {
    /// For each ball the first one equal to it.
    std::vector<std::uint32_t> first_equal;
    /// For each ball the largest other one in which it lies (touching it from within included; of several the
    /// first), or UINT32_MAX. Equal balls do not lie in each other.
    std::vector<std::uint32_t> enclosing;
};

/// Balls whose radii differ by little, compared with how far they spread along x, take O(n); other balls of
/// ordinary scenes O(n log n).
BallNesting ball_nesting(std::span<const Ball> balls);

}  // namespace vcell
