/// Linear equations for two unknowns. Eigen's decompositions are for any size: each source that names one
/// compiles it for two to seven seconds.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "../platform.hpp"

namespace vcell {

/// x with M x = k, by elimination from the row with the larger first number; not finite if M is singular.
/// Error: M x differs from k by a few roundings of |M| |x|.
inline Eigen::Vector2d solution(const Eigen::Matrix2d& M, const Eigen::Vector2d& k) {
    const int pivot = std::abs(M(1, 0)) > std::abs(M(0, 0)) ? 1 : 0, other = 1 - pivot;
    const double factor = M(other, 0) / M(pivot, 0);
    const double y = (k[other] - factor * k[pivot]) / (M(other, 1) - factor * M(pivot, 1));
    return {(k[pivot] - M(pivot, 1) * y) / M(pivot, 0), y};
}

/// x for which M x is nearest to k, by the columns' orthogonal parts; not finite if they are parallel.
inline Eigen::Vector2d nearest_solution(const Eigen::Matrix<double, 3, 2>& M, const Eigen::Vector3d& k) {
    const Eigen::Vector3d a = M.col(0).normalized(), across = M.col(1) - a.dot(M.col(1)) * a;
    const double y = across.dot(k) / across.squaredNorm();
    return {a.dot(k - y * M.col(1)) / M.col(0).norm(), y};
}

}  // namespace vcell
