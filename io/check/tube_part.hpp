/// A part of a complete cell around a tube, as the check takes it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "../../primitives/objects/objects.hpp"

namespace vcell::check {

/// Between two planes across the base's axis, along which that is on one side of each side of the box. Each
/// is judged as a cell around the stretch between them, which may lie outside the box: then rays come in
/// first.
struct TubePart {
    std::uint32_t number = 0;         ///< among Cell::parts
    std::array<Vec3, 2> ends;         ///< on the axis
    std::array<bool, 6> is_beyond{};  ///< which sides of the box the axis is outside of
    /// Numbers of the cell's elements that are this part's, ascending.
    std::vector<std::uint32_t> vertices, edges, faces;

    /// Do rays come into the box through a side?
    bool has_floor() const { return std::ranges::find(is_beyond, true) != is_beyond.end(); }
};

}  // namespace vcell::check
