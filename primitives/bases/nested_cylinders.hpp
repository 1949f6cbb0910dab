/// Which cylinders may lie in which: most pairs are told apart by their places across an axis alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../forms/cylinder_form.hpp"

namespace vcell {

/// For each cylinder, by its doubles, the others that may contain it, ascending: all that do are among them,
/// and those equal to it. Takes O(n log n) and the number of pairs that overlap where their axes' points
/// nearest to the middle of all are projected onto a line.
std::vector<std::vector<std::uint32_t>> possible_containers(std::span<const CylinderForm> cylinders);

}  // namespace vcell
