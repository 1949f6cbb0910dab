/// Spans of the edges beside cylinders over a plane base, conics and splines alike.
#pragma once

#include "../../core/platform.hpp"

#include <Eigen/Core>
#include <array>

namespace vcell {

/// A Bezier span of an edge with a cylinder on a side, in canonical coordinates: rational, all curves in one
/// parameter.
struct MixedSpan {
    static constexpr int largest_degree = 5;
    struct Trim {
        int degree = 0;  ///< 0: no cylinder on this side, its trim is the chart curve
        std::array<Eigen::Vector3d, largest_degree + 1> points;  ///< (u, v, w)

        Trim() { points.fill(Eigen::Vector3d::Zero()); }
    };

    int degree = 1;
    std::array<Eigen::Vector4d, largest_degree + 1> points;  ///< (x, y, height, w), w divided out
    std::array<Trim, 2> trims;                               ///< on the left and right

    MixedSpan() { points.fill(Eigen::Vector4d::Zero()); }
};

/// How far an edge's spans are from the true arc.
struct FitError {
    double chart = 0;  ///< distance of the chart curve from the arc's projection
    double space = 0;  ///< of the space curve from the arc, and of the lifted trims from the space curve
};

}  // namespace vcell
