/// Kinds of edges: what the two sites can meet in, and what control points tell.
#pragma once

#include "room.hpp"

namespace vcell::check {

/// Refutes kinds; an edge of the right kind gets no element of its own.
void certify_kinds(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
