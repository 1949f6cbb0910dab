/// Who owns a point's ray, and whether the point lies in the cell.
#pragma once

#include <optional>

#include "../primitives/bases/plane_base.hpp"
#include "../primitives/bases/radial_base.hpp"

namespace vcell {

struct PointAnswer {
    /// Owner of the ray; of sites that tie, the first. None at the centre of a sphere or on a cylinder's
    /// axis, where rays of all directions start.
    std::optional<Site> site;
    double clearance = 0;  ///< of the cell's boundary on the ray, length; meaningless without an owner
    bool inside = false;   ///< the point lies in the closed cell
};

/// Answers about the ray through a world point along the base's normal, decided exactly for the point
/// that canonical position rounds it to. None: the ray starts outside the base region.
std::optional<PointAnswer> query_point(const PlaneBaseProblem& problem, const Vec3& world);

/// Over a sphere or a cylinder: about the ray from the centre or axis. It is the one in the direction that
/// the chart's coordinates, in double, round the canonical point's to; along it, the point's exact distance
/// decides. At the pole of a sphere's chart it is a direction next to it, within 2^-30. What the cell's
/// boundary leaves of the base's body belongs to the cell. None: outside the stretch of a cylinder base.
std::optional<PointAnswer> query_point(const RadialBaseProblem& problem, const Vec3& world);

}  // namespace vcell
