/// A conic in the space of points and their distances from the base, and its trims.
#pragma once

#include "../../core/platform.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace vcell {

/// A homogeneous conic through (p, t), canonical, t the distance from the foot (chart.hpp): the weights
/// are 1, `weight`, 1, and `middle` is the middle control point times its weight.
struct ConicSpan {
    Eigen::Vector4d from, middle, to;
    double weight;

    /// The control polygon is no shorter than the curve: this bounds its length.
    double length() const {
        const Eigen::Vector4d corner = middle / weight;
        return (corner - from).norm() + (to - corner).norm();
    }
    Eigen::Vector3d half_way() const { return (from + 2 * middle + to).head<3>() / (2 + 2 * weight); }
    /// The parts before and after a parameter of [0, 1], and halves; reparametrised so that the ends' weights
    /// are 1 again.
    std::array<ConicSpan, 2> parts(double at) const {
        const Eigen::Vector4d before = (1 - at) * from + at * middle, after = (1 - at) * middle + at * to;
        const double weight_before = 1 - at + at * weight, weight_after = (1 - at) * weight + at,
                     weight_there = (1 - at) * weight_before + at * weight_after,
                     scale = 1 / std::sqrt(weight_there);
        const Eigen::Vector4d there = ((1 - at) * before + at * after) / weight_there;
        return {{{from, scale * before, there, scale * weight_before},
                 {there, scale * after, to, scale * weight_after}}};
    }
    std::array<ConicSpan, 2> halves() const {
        const double w = std::sqrt(0.5 * (1 + weight));
        const Eigen::Vector4d half_way = (from + 2 * middle + to) / (4 * w * w);
        return {{{from, (from + middle) / (2 * w), half_way, w}, {half_way, (middle + to) / (2 * w), to, w}}};
    }
};

/// Control points (u w, v w, w) of a conic span's trim, rational of degree 2 or 3.
struct ConicTrim {
    int degree;
    std::array<Eigen::Vector3d, 4> points;
};

}  // namespace vcell
