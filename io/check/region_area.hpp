/// The area of a base plane's region where walls of vessels leave a part of it.
#pragma once

#include <vector>

#include "integrals.hpp"

namespace vcell::check {

struct RegionArea {
    Interval area = 0.0;
    double slack = 0;  ///< what the errors of edges may change
};

/// In the frame's unit: what edges with a face on one side alone enclose on the plane. All others have faces
/// on both sides, and change nothing about what faces stand over together. `enough`: what of the area need
/// not be known better. Pre: as for integrate_faces(); the base is a plane.
RegionArea region_area(const Cell& cell, const Frame& frame, const std::vector<std::vector<EdgeUse>>& uses,
                       const std::vector<EdgeBand>& bands, double enough);

}  // namespace vcell::check
