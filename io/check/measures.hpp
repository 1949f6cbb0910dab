/// Measures: lengths, areas, volumes and clearances, enclosed by integrals and bounds of this room's own and
/// compared with what is stated.
///
/// What is stated with a bound b on its error is
///   - refuted, where it is farther than b from all that the enclosure allows; where b is 2^20 times larger
///   than
///     the enclosure needs it (a bound that excludes nothing is none); and where b is smaller than the last
///     place of the number, which a number that is not exact cannot keep;
///   - proved, where all that the enclosure allows is within b, or the enclosure is as narrow as b, the
///   rounding of
///     coordinates and what the edges' own errors may change together; how far the number is from the true
///     one at most is the amount that the certificate names;
///   - open otherwise.
#pragma once

#include <span>

#include "edges.hpp"
#include "parts.hpp"
#include "room.hpp"

namespace vcell::check {

/// What certify_edges() found tells how far edges may be from the true ones. `subjects`: all parts of the
/// cell; `slabs`: what they leave out, if there are such. With its volume the cell's is enclosed; areas and
/// clearances are those of the parts, and the bounds on areas may have room for about as much as faces across
/// slabs have. False: integrals by which faces are said to stand over all of the base are estimates.
bool certify_measures(std::span<const Subject> subjects, std::span<const EdgeBound> edges,
                      const TubeParts* slabs, const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
