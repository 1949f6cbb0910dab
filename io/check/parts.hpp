/// The parts that a complete cell around a tube comes in (envelope/complete_tube.hpp).
///
/// What is proved of them here:
///   - they follow each other along the axis, and each keeps so far clear of the planes of the box's sides
///     that the axis is on one side of each: so rays come in through the sides that it is beyond, through
///     all of each, and through no others;
///   - what the box has between them, before the first and after the last are slabs across the axis, which
///     are thin. Nothing is said of what is in them, but how much that is at most: as wide as they are
///     together, times the largest section of the box across the axis. What of them is as deep in another
///     object as the base is wide is nearer to that, and does not count.
#pragma once

#include <optional>
#include <vector>

#include "../../envelope/cell.hpp"
#include "certificate.hpp"
#include "scene.hpp"
#include "space.hpp"
#include "tube_part.hpp"

namespace vcell::check {

struct TubeParts {
    std::vector<TubePart> parts;
    double width = 0;     ///< of all slabs together, at most
    double left_out = 0;  ///< a bound on their volume
    double area = 0;      ///< what bounds on areas may allow for faces and sides of the box in them
};

/// None: something is refuted or open, without which no part can be judged. Elements that no face uses are
/// the first part's. Pre: a complete cell around a tube; the structure holds.
std::optional<TubeParts> certify_parts(const Cell& cell, const SceneGeometry& geometry,
                                       Certificate& certificate);

}  // namespace vcell::check
