/// Cells of scenes that change, from the cells of what they were: an object that owns no part of a cell's
/// boundary and shares none owns none either when others join it. So what is computed is the cell among the
/// few that do, and costs what they cost, however many objects the scene has. Complete cells are an
/// exception: rays that come in through a side of the box may end before, at objects that show nowhere, so
/// that all objects are looked at.
///
/// Each result is the cell of the changed scene as voronoi_cell() gives it, complete if the (first) cell was,
/// but for its report, which is about the objects that were looked at. Of a cell of a whole diagram
/// (DiagramOptions::visit) the scene is what it was found among; its objects' places are their numbers from
/// then on. Throws as voronoi_cell() does. Pre: the cells are those of their scenes.
#pragma once

#include <cstdint>

#include "voronoi_cell.hpp"

namespace vcell {

/// The cell with one more object, which gets the next number.
Cell insert(Cell cell, const Object& object, const CellOptions& options = {});

/// The cell without the object of that number; the objects after it get numbers lower by one. Of balls only
/// those are looked at that are near enough to reach a cell as large as the one among the remaining
/// neighbours, so it takes O(n) and what these cost. Throws InputError if there is no such object, or if it
/// is the base.
Cell remove(Cell cell, std::uint32_t number, const CellOptions& options = {});

/// The cell among the objects of both, those of the second numbered after those of the first; an object that
/// is the base is left out of the second's. Throws InputError if they have not the same base, box, probe and
/// units.
Cell merge(Cell first, const Cell& second, const CellOptions& options = {});

/// The objects that own a part of the cell's boundary or share one, be it a vertex, ascending.
std::vector<std::uint32_t> neighbors_and_ties(const Cell& cell);

}  // namespace vcell
