/// Faces: patches on their bisectors, nothing nearer, trimming curves on their edges.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_faces(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
