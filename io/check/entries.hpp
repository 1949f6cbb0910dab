/// Proves of a complete cell that nothing nearest to the base is missing, and that nothing is there twice.
///
/// Faces of a cell that are proved bound all of it that hangs together with them. What else there might be
/// begins on a side of the box through which rays come in, as no ray that starts in the box is without its
/// face (tiling.hpp). On such a side, as far as it is in front of a base plane by more than rounding, or
/// between the ends of a part of a tube, a convex polygon W, let f be the least excess of the objects, and F
/// what the cell's faces cover there: f > 0 on a part that is missing, and 0 where it ends inside W, so that
/// f has a maximum p in it, which is in F or on its boundary nowhere, as f = 0 on the boundary of F inside W.
/// W is divided into rectangles, and in none of them is such a p:
///   - in one all over which an object's excess is negative, or no more than rounding, f is, too: where f is
///     below that all over a part, what is missing is as good as none;
///   - one that no edge of F meets but such as lie on the boundary of W, and of which a point in W is in F,
///   is
///     in F as far as it is in W;
///   - one from which a way leads to a part that is in F, and f > 0 on all of it, is in F;
///   - where there is a direction in which all excesses grow that may be the least somewhere in it, and which
///     does not lead out of W through any of its sides that meet it, no point of it is a maximum.
///
/// A face on such a side ends where f = 0, so that two that overlap are the same, or the same with what lies
/// between them. So none is there twice where a point of each lies in no other one.
#pragma once

#include <span>

#include "edges.hpp"
#include "room.hpp"

namespace vcell::check {

/// Of cells that are complete; has nothing to say about others.
void certify_entries(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                     Certificate& certificate);

}  // namespace vcell::check
