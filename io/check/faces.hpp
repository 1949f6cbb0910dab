/// Faces: a patch lies on its bisector, and no other site is nearer anywhere inside its trims.
///
/// On the bisector of site i the excess of a site k has its least value over a face on the face's boundary,
/// where the edges are judged, or at a point where its gradient and that of i's excess are parallel. So
/// beside the boundary nothing has to be resolved: a part of the patch needs no other proof than that the
/// two gradients are nowhere parallel in it, or that k is farther.
#pragma once

#include <span>

#include "edges.hpp"
#include "room.hpp"

namespace vcell::check {

/// What certify_edges() found bounds the boundaries of faces.
void certify_faces(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                   Certificate& certificate);

}  // namespace vcell::check
