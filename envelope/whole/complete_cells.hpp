/// The whole cells of a diagram's planes and tubes, with faces, for those who look at them.
#pragma once

#include <cstdint>
#include <vector>

#include "cell_finder.hpp"

namespace vcell::whole {

/// The scene of an object, but for the others and the box.
Scene scene_without_others(const DecidedDiagram& decided, std::uint32_t object);

/// The scene of an object among all others, or where the box repeats among all images that may come near to
/// its cell, in a box that holds one period of that (tube_room()); of a plane that of its other side, too.
/// Pre: the object is no ball where the box repeats.
std::vector<Scene> scenes_among_all(const DecidedDiagram& decided, std::uint32_t object);

/// A tube's cell, and those on the two sides of a plane, complete (CellOptions::complete), among all objects.
/// None where there is no such cell (docs/promises.md, "Limits"). Pre: the object has a cell and is no ball
/// in the box, which find_cell() has.
std::vector<Cell> complete_cells(const DecidedDiagram& decided, std::uint32_t object);

struct WholeCells {
    DiagramCell measured;
    std::vector<Cell> cells;
};
/// find_cell(), and the cells that it measures or complete_cells() has; none where there is nothing to see.
/// Pre: find_cell()'s.
WholeCells find_whole_cells(const DecidedDiagram& decided, std::uint32_t object);

}  // namespace vcell::whole
