/// Edges: equally far from the base and from both sites all along, nothing nearer; kinds.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_edges(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
