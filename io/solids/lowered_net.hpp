/// Nets of a higher degree than their surfaces'.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace vcell {

struct LoweredNet {
    std::vector<Eigen::Vector4d> net;  ///< three times three homogeneous points, [3 i + j]
    double lost = 0;  ///< how far coordinates and weights, and their derivatives, may be off in the domain
};

/// A net of degrees m and n, homogeneous with positive weights, as one of degree two in both. Of degree two,
/// but for rounding, are the surfaces whose degree was raised until their weights were positive
/// (envelope/lift/radial_patch.hpp); powers of high degrees would cancel, and those of the lower net do not.
/// The degree is the most that a difference may grow by in a derivative.
inline LoweredNet lowered_net(const std::vector<Eigen::Vector4d>& all, std::size_t m, std::size_t n) {
    using Eigen::Vector4d;
    const auto lowered = [](const std::vector<Vector4d>& b) {
        const std::size_t d = b.size() - 1;
        const double half = 0.5 * static_cast<double>(d);
        const Vector4d from_first = b[0] + half * (b[1] - b[0]), from_last = b[d] + half * (b[d - 1] - b[d]);
        return std::array<Vector4d, 3>{b[0], 0.5 * from_first + 0.5 * from_last, b[d]};
    };
    // What a raised net's control point has of each of the lower one's.
    const auto shares = [](std::size_t degree, std::size_t place) -> Eigen::Vector3d {
        const auto d = static_cast<double>(degree), i = static_cast<double>(place);
        return Eigen::Vector3d((d - i) * (d - i - 1), 2 * i * (d - i), i * (i - 1)) / (d * (d - 1));
    };
    std::vector<Vector4d> columns;  // three for each j
    for (std::size_t j = 0; j <= n; ++j) {
        std::vector<Vector4d> column;
        for (std::size_t i = 0; i <= m; ++i) column.push_back(all[i * (n + 1) + j]);
        for (const Vector4d& c : lowered(column)) columns.push_back(c);
    }
    LoweredNet result;
    for (std::size_t i = 0; i < 3; ++i) {
        std::vector<Vector4d> row;
        for (std::size_t j = 0; j <= n; ++j) row.push_back(columns[3 * j + i]);
        for (const Vector4d& c : lowered(row)) result.net.push_back(c);
    }
    for (std::size_t i = 0; i <= m; ++i)
        for (std::size_t j = 0; j <= n; ++j) {
            Vector4d off = all[i * (n + 1) + j];
            for (Eigen::Index k = 0; k < 3; ++k)
                for (Eigen::Index l = 0; l < 3; ++l)
                    off -=
                        shares(m, i)[k] * shares(n, j)[l] * result.net[static_cast<std::size_t>(3 * k + l)];
            result.lost = std::max(result.lost, off.cwiseAbs().maxCoeff());
        }
    result.lost *= static_cast<double>(std::max(m, n));
    return result;
}

}  // namespace vcell
