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

/// Faces are cut before the tips of hollow tubes' and cones' bisectors: where a patch has one for a side it
/// ends along a curve from seam to seam, as a loop in CAD has an edge on each side. Beyond that the surface
/// goes on in a patch of its own, a cap, of which the tip is one corner: of parameters over [0, 1]
/// whose axes are the seams. Nothing is approximated: a cap is rational, of the product of the surface's
/// degrees in either parameter. A tip that is not between two straight seams, or that another trim comes to
/// but for rounding, has none.
CappedFaces with_tip_caps(const std::vector<CellFace>& faces);

}  // namespace vcell
