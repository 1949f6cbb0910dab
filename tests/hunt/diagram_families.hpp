/// Families of whole diagrams on which cells are hard to come by, in boxes that repeat or do not.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <string>

#include "../../envelope/voronoi_diagram.hpp"

namespace vcell::hunt {

/// Along which axes the box repeats: none, x, x and y, all, and all of a box that leans.
enum class Room : std::uint8_t { Box, Pipe, Slit, Repeating, Leaning };
inline constexpr Room rooms[] = {Room::Box, Room::Pipe, Room::Slit, Room::Repeating, Room::Leaning};
std::string to_string(Room room);  ///< "box", "pipe", "slit", "repeating", "leaning"

/// No two objects of a scene cut each other in a way that leaves one without a cell, images included as far
/// as the next box, but in families whose boxes are smaller than their objects.
struct DiagramFamily {
    const char* name;
    const char* about;
    DiagramScene (*make)(std::mt19937_64& rng, Room room);
};

std::span<const DiagramFamily> diagram_families();

}  // namespace vcell::hunt
