/// Moments, where the file has them: against a quadrature of the check's own over the patches as written.
/// What it leaves out is estimated, so that it proves nothing, and leaves open what contradicts it.
#pragma once

#include "room.hpp"

namespace vcell::check {

/// Nothing is told where the file has no moments, or not all of the boundary (no `closing`, though there is a
/// rim).
void certify_moments(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
