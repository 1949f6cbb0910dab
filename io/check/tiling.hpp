/// Faces tile the base region: uses of edges, labels, loops, seams, Euler's relation; every base point
/// under one face.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_tiling(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
