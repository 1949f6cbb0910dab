/// The cell of a tube in one piece: what its parts have where one ends and the next one begins is one.
#pragma once

#include <cstdint>
#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

/// A complete cell around a tube comes in parts (Cell::parts), and between them slabs are left out, mostly
/// 2^-31 of the box's diagonal wide (complete_tube.hpp): the section of the cell across the axis
/// is one and the same on both sides of a slab, but for that.
struct JoinedParts {
    /// As the cell was, with all elements and their numbers, but without parts. Where two of them meet, the
    /// loops of both have one edge, the first part's, whose `sites` are the face's site, twice; its ends are
    /// the first part's vertices, and in the sites of these the ends of the stretch are not listed any more.
    /// The other part's edges and vertices there are left over: nothing has them. An edge has in its `error`
    /// how far trims of the other part are from it, at 65 places.
    Cell cell;
    /// The edges where parts meet, with one site on both sides.
    std::vector<bool> is_joint;
    /// The vertices in which an edge goes on beyond a joint: two edges besides joints end there.
    std::vector<bool> is_passed;
};

/// `most` is a part of the box's diagonal, and what is no longer than that is a point: sides of sections that
/// are so short have no edge, and a section that is all so narrow, where a part begins or ends along an edge
/// of the box or in a corner, is an edge between its two long sides, or nothing. Parts stay apart, with ends
/// of their own, where sections on both sides of a slab have not the same sites in the same order around them
/// but for that, or would be off by more.
JoinedParts joined_parts(const Cell& cell, double most = 0x1p-20);

}  // namespace vcell
