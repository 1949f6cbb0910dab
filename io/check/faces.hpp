/// Faces: a patch lies on its bisector (patch_distance.cpp), and no other site is nearer anywhere inside its
/// trims (patch_rivals.cpp).
#pragma once

#include <span>

#include "edges.hpp"
#include "room.hpp"

namespace vcell::check {

/// What certify_edges() found bounds the boundaries of faces.
void certify_faces(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                   Certificate& certificate);

}  // namespace vcell::check
