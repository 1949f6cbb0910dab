/// That no site but its own is nearer anywhere along an edge.
#pragma once

#include <optional>

#include "certificate.hpp"
#include "judged_edge.hpp"
#include "subject.hpp"

namespace vcell::check {

/// How far from the true boundary a site that is nearer by less than the edge's error tells leaves the curve,
/// which is within `distance` of the arc of its own sites. None: another one is nearer, or may be.
std::optional<double> certify_no_rivals(const JudgedEdge& edge, double distance, const Subject& subject,
                                        const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
