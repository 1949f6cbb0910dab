#include "edge_trims.hpp"

#include <cmath>

namespace vcell {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

ConicTrim cubic_trim(const PatchCoordinates& coordinates, int angle, const ConicSpan& span) {
    const auto of_end = [&](const Vector4d& X) -> Vector2d {  // the angle's numerator over the root, the root
        const double root = std::sqrt(PatchCoordinate::value(coordinates[angle].divisor, X, 1));
        return {PatchCoordinate::value(coordinates[angle].numerator, X, 1) / root, root};
    };
    const PatchCoordinate::Linear& length = coordinates[1 - angle].numerator;
    const std::array a{of_end(span.from), of_end(span.to)};
    const std::array b{Vector2d(PatchCoordinate::value(length, span.from, 1), 1),
                       Vector2d(PatchCoordinate::value(length, span.middle, span.weight), span.weight),
                       Vector2d(PatchCoordinate::value(length, span.to, 1), 1)};
    const auto product = [&](int i, int k) {
        Vector3d p;
        p[angle] = a[i][0] * b[k][1];
        p[1 - angle] = a[i][1] * b[k][0];
        p[2] = a[i][1] * b[k][1];
        return p;
    };
    return {3,
            {product(0, 0), (2 * product(0, 1) + product(1, 0)) / 3, (product(0, 2) + 2 * product(1, 1)) / 3,
             product(1, 2)}};
}

}  // namespace vcell
