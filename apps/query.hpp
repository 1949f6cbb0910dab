/// Who owns a point's ray, and whether the point lies in the cell.
#pragma once

#include <optional>

#include "../primitives/plane_base.hpp"

namespace vcell {

struct PointAnswer {
    Site site;             ///< owner of the ray; of sites that tie, the first
    double clearance = 0;  ///< height of the cell's boundary on the ray, length
    bool inside = false;   ///< the point lies in the closed cell
};

/// Answers about the ray through a world point along the base's normal, decided exactly for the point
/// that canonical position rounds it to. None: the ray starts outside the base region.
std::optional<PointAnswer> query_point(const PlaneBaseProblem& problem, const Vec3& world);

}  // namespace vcell
