/// How far the root of a system is from a point, where its Jacobian is near a matrix all around.
#pragma once

#include <Eigen/LU>
#include <array>

#include "../../platform.hpp"

namespace vcell {

/// Let F have N equations in N unknowns and let row i of its Jacobian be within variations[i] of that of M
/// all over a convex set. With B nearly the inverse of M, B_i its columns, q >= |I - B F'| there. If q < 1, X
/// - B F(X) contracts: F is one-to-one in the set, and a root lies within sum |B_i| |F_i(P)| / (1 - q) of any
/// of its points P whose ball of that radius it contains [Deuflhard04, sec. 2.1].
///
/// In doubles: `rounding` bounds what they change about the rows, and about q.
template <int N>
struct RootDistance {
    using Matrix = Eigen::Matrix<double, N, N>;

    Matrix inverse;
    std::array<double, N> columns;
    double q;

    RootDistance(const Matrix& M, const std::array<double, N>& variations, double rounding)
        : inverse(M.inverse()) {
        q = (Matrix::Identity() - inverse * M).norm();
        for (int i = 0; i < N; ++i) {
            columns[i] = inverse.col(i).norm();
            q += columns[i] * (variations[i] + rounding);
        }
    }
    bool is_regular() const { return q < 1; }
    /// residuals: of F at the point.
    double distance(const std::array<double, N>& residuals) const {
        double sum = 0;
        for (int i = 0; i < N; ++i) sum += columns[i] * residuals[i];
        return sum / (1 - q);
    }
};

}  // namespace vcell
