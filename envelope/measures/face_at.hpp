/// Which face of a cell holds a point of its boundary.
#pragma once

#include <cstdint>
#include <optional>

#include "../cell.hpp"

namespace vcell {

/// The face of a site that holds p, a point of the boundary that is as near to the base as to the site: the
/// trims of patches tell, in whose parameters p is looked for. None where p is so
/// near to a trim or a seam that samples of these do not tell, and where no patch or more than one holds it.
/// If the site has one face alone, it is that.
std::optional<std::uint32_t> face_at(const Cell& cell, Site site, const Vec3& p);

}  // namespace vcell
