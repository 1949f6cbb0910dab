/// Trimming curves and the edges they run along.
#pragma once

#include <algorithm>

#include "../../envelope/cell.hpp"

namespace vcell {

/// The edge's parameter at parameter t of a trimming curve along it, and the other way round. They share it,
/// or run against each other; where a seam cuts an edge, a trimming curve's domain is a part of the edge's.
inline double edge_parameter(const TrimCurve& trim, const RationalCurve3& edge, double t) {
    return trim.reversed ? edge.domain_begin() + edge.domain_end() - t : t;
}

/// Is a parameter of the patch, the first one (0) or the second (1), one number all along the curve?
inline bool is_at_one(const RationalCurve2& curve, int parameter) {
    return std::ranges::all_of(curve.points, [&](const Eigen::Vector3d& p) {
        return p[parameter] == curve.points.front()[parameter];
    });
}

}  // namespace vcell
