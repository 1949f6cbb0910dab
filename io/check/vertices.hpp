/// Vertices: the true point is enclosed by Krawczyk's operator on three of its sites [Krawczyk69,
/// Neumaier90], the stated one within its error of it; all other sites are ties that the vertex lists, or
/// farther.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_vertices(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
