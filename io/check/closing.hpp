/// What closes the cell: walls, the base's region and ends, as far as the file has them.
///
/// All of it is flat, and so is bounded by what bounds it: feet where two sides of the box and the base meet,
/// lines between proved vertices, and the rim's edges, which are judged elsewhere. Each face lies in the
/// plane of its site, its trims lift to their edges, and every edge, the cell's own ones included, is used
/// once each way.
#pragma once

#include <span>

#include "edges.hpp"
#include "room.hpp"

namespace vcell::check {

/// What certify_edges() found bounds the rim. `subjects`: all parts of the cell. Without a `closing` there is
/// nothing to judge.
void certify_closing(std::span<const Subject> subjects, std::span<const EdgeBound> edges,
                     const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
