/// Level curves of the clearance on the faces of a cell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

/// A part of a level curve within a face. A closed one's first point is its last, too.
struct Contour {
    std::size_t level;   ///< which one of those asked for
    std::uint32_t face;  ///< of the cell
    std::vector<Vec3> points;

    bool is_closed() const { return points.front() == points.back(); }
};

/// About so many round clearances, with equal steps, strictly between the least and the greatest one of the
/// cell: no more than `count`. None where the clearance does not vary.
std::vector<double> round_levels(const Cell& cell, std::size_t count);

/// Points lie on their face's bisector at their clearance to rounding, except where a face touches its own
/// level curve, as at an apex; chords are within 1e-4 of the cell's diagonal of the curve. Loops about an
/// apex that are smaller than an 80th of the diagonal may be left out.
std::vector<Contour> contours(const Cell& cell, std::span<const double> levels);

}  // namespace vcell
