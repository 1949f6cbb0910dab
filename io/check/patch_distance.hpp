/// How far a patch is from its bisector.
#pragma once

#include <optional>

#include "certificate.hpp"
#include "judged_patch.hpp"
#include "subject.hpp"

namespace vcell::check {

/// By what rounding of the patch's numbers makes of zero, or no more than its boundary is, which lies as far
/// from the true one as that says if it is known; or, where halves are no nearer to it, by what its edges
/// state. None: that is refuted, or left open.
std::optional<double> certify_on_bisector(const JudgedPatch& judged, const std::optional<double>& boundary,
                                          const Subject& subject, const CheckOptions& options,
                                          Certificate& certificate);

}  // namespace vcell::check
