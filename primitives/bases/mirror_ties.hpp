/// Objects that lie behind a mirror of the base.
///
/// Let a tube T along the base have its radius, and M be the plane half-way between the two axes. The cell is
/// on the base's side of M. Let Y be a ball with its centre, or a tube with its axis, on that side, parallel
/// to M, and X be its mirror image in M. Squares of distances from what mirrors the other differ by a linear
/// function that is 0 on M, so on the base's side nothing is nearer to X than to Y:
///
///     d(base) <= d(T),  d(base) <= d(Y)   imply   d(base) <= d(X) :
///
/// X bounds nothing. But it is as near as T and Y all along the curve on which these tie, as at the corners
/// of nets in layers and of lattices, and no digits tell it from them there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../objects/objects.hpp"

namespace vcell {

struct MirrorTie {
    std::uint32_t hidden, mirrored, mirror;  ///< X, Y and T by their places in the list
    /// 0: exact; otherwise a bound on how much less from the base than from T and from Y it is where X is
    /// nearer.
    double off;
};

/// All ties of that kind, exact or of what would have to be moved by `most`, a length, at most, but those by
/// which something would be hidden by what it hides; `objects` that are null take no part. Where tubes along
/// the base of its radius are more than some, they are none, as looking at all pairs would take longer than
/// the cell.
std::vector<MirrorTie> find_mirror_ties(const Cylinder& base, std::span<const Object* const> objects,
                                        double most);

}  // namespace vcell
