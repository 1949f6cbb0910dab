/// That no site but its own is nearer anywhere on a patch.
///
/// On the bisector of site i the excess of a site k has its least value over a face on the face's boundary,
/// where the edges are judged, or at a point where its gradient and that of i's excess are parallel. So
/// beside the boundary nothing has to be resolved: a part of the patch needs no other proof than that the
/// two gradients are nowhere parallel in it, or that k is farther.
#pragma once

#include "certificate.hpp"
#include "judged_patch.hpp"
#include "subject.hpp"

namespace vcell::check {

/// Is that proved? `margin`: how far the patch is from its bisector.
bool certify_no_rivals(const JudgedPatch& judged, double margin, const Subject& subject,
                       const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
