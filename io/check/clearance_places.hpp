/// Places of the least and the greatest clearance, where the file has them. How far the clearance there is
/// from the cell's own is judged with the measures (measures.hpp).
#pragma once

#include <span>

#include "room.hpp"

namespace vcell::check {

/// Refutes a place that has not the sites of the one element that it names, or that is farther from the base
/// or from these than its error allows, beyond another object, or outside the box. That the element has it is
/// not proved. `subjects`: all parts of the cell.
void certify_clearance_places(std::span<const Subject> subjects, const CheckOptions& options,
                              Certificate& certificate);

}  // namespace vcell::check
