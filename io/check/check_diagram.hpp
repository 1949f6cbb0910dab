/// vcell check: proves that a diagram is what its file says, from the objects in it alone.
///
/// Each cell is judged as a cell by certify(), among all balls that can be as near to anything of it as its
/// own: those no farther from the ball's surface than twice the cell's largest clearance, which certify()
/// proves, too. Then
///   - a ball without a cell lies in another one, or equals one of a lower number;
///   - pairs: two cells have as many faces between them, one area within both bounds, and the same vertices,
///     by all of their sites and within both errors;
///   - the volumes' enclosures add up to one of the box's volume.
/// Nothing that computed the diagram takes part.
#pragma once

#include <utility>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "check.hpp"

namespace vcell {

/// A diagram of balls as its file has it.
struct StoredDiagram {
    DiagramScene scene;
    /// By ball, ascending; sites of elements are the balls' numbers. Their scenes are left out.
    std::vector<std::pair<std::uint32_t, Cell>> cells;
};

/// Elements are named "cells[7].vertices[3]", by the ball's number, "pairs[7, 9]" and "volume"; what is said
/// of a cell's elements numbers the balls that can reach the cell, ascending, from 0. The bytes are the same
/// for any number of threads. Pre: the scene's objects are balls, in a box that does not repeat, without a
/// probe.
Certificate certify(const StoredDiagram& diagram, const CheckOptions& options = {}, unsigned threads = 1);

}  // namespace vcell
