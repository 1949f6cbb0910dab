/// How well an edge's curve follows the true arc.
///
/// The excesses of two sites are a map f of space to the plane. Where the least singular value of its
/// derivative is at least s, all within |f| / s of a point, there is a zero that close: the flow of Newton's
/// method, x' = -J^+ f, leads there on a path no longer than that [Deuflhard04, 3.3].
#pragma once

#include <optional>

#include "edges.hpp"
#include "judged_edge.hpp"

namespace vcell::check {

/// Within its error, all along. None: that is refuted, or left open.
std::optional<EdgeBound> certify_on_arc(const JudgedEdge& edge, const Subject& subject,
                                        const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
