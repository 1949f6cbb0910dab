/// The cells in the order of their objects' numbers, as files have them: each rank with a range of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene_parts.hpp"

namespace vcell::mpi {

/// What the rank has of the range of numbers from `first` on.
struct OrderedCells {
    std::uint32_t first = 0;
    DiagramScene scene;  ///< their objects, as the file has them, with their names and groups
    std::vector<DiagramCell> cells;
    std::vector<Contact> contacts;    ///< whose first object is in the range, ascending
    std::vector<std::string> faults;  ///< of these pairs, as ContactTable has them
    /// What contacts' objects are, ascending by number, for write_contact_rows().
    DiagramScene paired;
    std::vector<std::uint32_t> paired_numbers;
};

/// `cells` are those of the own objects, in their order.
OrderedCells in_order(Ranks& ranks, const SceneParts& parts, std::vector<DiagramCell> cells);

/// filled_volume() of all of them, on the first rank.
FilledVolume filled_volume(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered);

}  // namespace vcell::mpi
