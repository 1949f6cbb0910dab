/// A path through a cube from neighbour to neighbour, for elements that are asked for with what lies about
/// them to lie side by side in memory.
#pragma once

#include "platform.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

namespace vcell {

/// Where on Morton's path through an octree of 2^30 cubes the point lies. Pre: coordinates in [-1, 1].
inline std::uint32_t octree_path(const Eigen::Vector3d& p) {
    // Ten bits of a coordinate, each followed by two zeros.
    const auto spread = [&](int k) {
        auto x = std::min(static_cast<std::uint32_t>(512 * (1 + p[k])), 0x3ffu);
        x = (x | x << 16) & 0x30000ffu;
        x = (x | x << 8) & 0x300f00fu;
        x = (x | x << 4) & 0x30c30c3u;
        return (x | x << 2) & 0x9249249u;
    };
    return 4 * spread(0) + 2 * spread(1) + spread(2);
}

}  // namespace vcell
