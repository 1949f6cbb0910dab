/// Vertices: equally far from the base and from each of their sites, nothing nearer.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_vertices(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
