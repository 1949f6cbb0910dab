/// Which face of a cell holds a point of its boundary.
#pragma once

#include <cstdint>
#include <optional>

#include "../cell.hpp"

namespace vcell {

/// Of the cell's faces of this site, the one that holds p, a point of the boundary that is as near to the
/// base as to the site: by the trims of its patches, in whose parameters p is looked for. None where p is so
/// near to a trim or a seam that samples of these do not tell, and where no patch or more than one holds it.
/// If the site has one face alone, it is that.
std::optional<std::uint32_t> face_at(const Cell& cell, Site site, const Vec3& p);

}  // namespace vcell
