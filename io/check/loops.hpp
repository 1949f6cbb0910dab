/// Loops of patches in their parameters, and the edges around each face.
#pragma once

#include "check.hpp"
#include "subject.hpp"

namespace vcell::check {

/// Refutes loops whose curves do not run head to tail, that turn the wrong way, or lie outside the outer one;
/// and faces whose edges are not closed.
void certify_loops(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
