/// Faces tile the base region. What is proved, and how it follows:
///   - each edge is used once from either side, or once and over the rim; around each face edges are closed,
///   vertex
///     to vertex; seams are matched in pairs; there are no isolated vertices, no edges without length, none
///     between a site and itself; Euler's relation holds. So the shadows of all faces on the base have no
///     boundary but the rim, and all base points off the edges lie under the same number of faces, counted
///     with their orientation (the degree of a map is constant);
///   - that number is the area of all shadows for that of the region (measures.hpp): one;
///   - inside a face's trims no other site is nearer (faces.hpp), so that over a point none but faces of the
///   nearest
///     site count; loops run the right way around, holes lie in their faces.
#pragma once

#include "room.hpp"

namespace vcell::check {

void certify_tiling(const Subject& subject, const CheckOptions& options, Certificate& certificate);

/// Refutes what base points at random contradict: a look at cells of which something is not proved.
void sample(const Subject& subject, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
