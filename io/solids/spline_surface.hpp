/// Patches with inner knots: the same surfaces, in parts that other programs integrate over one by one.
#pragma once

#include <vector>

#include "../../core/curves/bspline.hpp"

namespace vcell {

/// A rational tensor-product B-spline surface over full, clamped knot vectors, inner knots simple.
struct SplineSurface {
    int degree_u = 1, degree_v = 1;
    std::vector<double> knots_u, knots_v;
    std::vector<std::vector<Eigen::Vector4d>> points;  ///< [i][j] = (x, y, z, w): u-index i, v-index j
};

/// The patch, point for point, with knots between which rules of few points suffice: CAD programs integrate a
/// surface span by span, and over a patch around which weights change by much theirs are far off (a tenth of
/// a cell's volume was seen). A span is halved until the rule of four points for the volume under the patch,
/// along lines in both directions, changes by less than `accuracy` (length cubed), but no more than six
/// times.
SplineSurface with_knots(const RationalPatch& patch, double accuracy);

}  // namespace vcell
