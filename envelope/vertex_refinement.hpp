/// Vertices of a cell to more digits than doubles have.
///
/// A vertex is known by where it comes from: the base and three of its sites, whose equations hold in it
/// (primitives/bisectors/vertex_system.hpp), and the ball of its stated error, which tells which of their
/// common points it is. Both are in every cell, computed or read from a file.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "../core/numbers/wide.hpp"
#include "cell.hpp"

namespace vcell {

struct RefinedVertex {
    /// Those of the vertex's sites whose bisectors with the base cross in it at the widest angles.
    std::array<Site, 3> sites;
    /// x, y, z and clearance, world: the one point that these three and the base have in common within the
    /// vertex's error is in it.
    std::array<Wide, 4> box;
    /// A bound on how far that point is from being equally far from the vertex's other sites; 0 where it has
    /// none. Where they tie exactly it is as small as the box.
    double tie_width = 0;
};

/// The most digits that can be asked for: Wide's, less what cancels.
constexpr int most_refined_bits = 256;

/// Encloses a vertex of the scene as read, within 2^-bits of the box's diagonal in each coordinate. None
/// where the vertex is_touching; where its stated error does not hold one common point, and one only, as far
/// as the interval-Newton method proves it (bisectors that all but touch); where its digits do not suffice.
/// Pre: vertex < cell.vertices.size(), 0 < bits <= most_refined_bits.
std::optional<RefinedVertex> refine(const Cell& cell, std::size_t vertex, int bits);

}  // namespace vcell
