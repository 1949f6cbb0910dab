/// Caps on the tips of faces, for programs to which the side of a patch that is one point is none.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

struct CappedFaces {
    std::vector<CellFace> faces;
    /// The tips, and where caps cut seams.
    std::vector<Vec3> places;
    /// The numbers of the places where a seam starts and ends, in the sense of its first trim among the
    /// faces, of seams that have one: a seam without starts and ends at edges.
    std::unordered_map<std::uint32_t, std::array<std::optional<std::uint32_t>, 2>> ends;
};

/// The same faces, but that patches which have the tip of a hollow tube's or cone's bisector for a side, a
/// loop with a gap and no edge in CAD, end before it, along a curve from seam to seam. Beyond that the
/// surface goes on in a patch of its own, a cap, of which the tip is one corner: of parameters over [0, 1]
/// whose axes are the seams. Nothing is approximated: a cap is rational, of the product of the surface's
/// degrees in either parameter. A tip that is not between two straight seams, or that another trim comes to
/// but for rounding, has none.
CappedFaces with_tip_caps(const std::vector<CellFace>& faces);

}  // namespace vcell
