/// What all cells of a diagram say together, from cells that are not all in one place.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "../voronoi_diagram.hpp"
#include "image_tree.hpp"

namespace vcell::whole {

/// What the cell `owner` shares with a neighbour, as the pair of them is listed (ContactTable).
struct ContactSide {
    std::uint32_t first;
    Site second;
    Image image;
    std::uint32_t owner;
    std::uint32_t faces;
    double area, area_error;
};

/// `periods` as VoronoiDiagram has them; of objects that are no part of them there are none.
ContactSide contact_side(std::uint32_t owner, const CellContact& contact,
                         std::span<const ObjectImage> periods);

/// Must the cell list all of its contacts? It is computed, its errors are proven, and it has a volume: what
/// lies beyond a side of the box and is the mirror image of an object in it has none, and the cell of that
/// object has a face with it in the side.
bool knows_contacts(const DiagramCell& cell);

/// The pairs of these sides; faults are of pairs that do not fit, and of sides without the other one where
/// is_known(cell) says that the cell without it knows_contacts(). Pre: of each pair all sides that there are.
ContactTable pair_up(std::vector<ContactSide> sides, const std::function<bool(std::uint32_t)>& is_known);

/// filled_volume() in parts.
class VolumeSum {
public:
    /// `moved` as VoronoiDiagram has it.
    VolumeSum(const DiagramScene& scene, double moved);
    /// Cells, ascending by object over all calls: then sums are the same doubles whatever the parts are.
    void add(std::span<const DiagramCell> cells);
    /// Pre: that many cells were added.
    FilledVolume of(std::size_t cells) const;

    FilledVolume so_far;
};

}  // namespace vcell::whole
