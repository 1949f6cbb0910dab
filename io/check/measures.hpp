/// Measures, re-integrated: lengths, areas, volumes; clearances, neighbours, the report.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_measures(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
