/// Tubes that keep clear of each other.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "../primitives/objects/objects.hpp"

namespace vcell {

/// Through random points of [0, 10]^3 in random directions, 0.02 apart at least.
inline std::vector<Object> random_tubes(std::mt19937_64& rng, std::size_t count, double most_radius) {
    std::uniform_real_distribution<double> coordinate(0, 10), component(-1, 1), radius(0, most_radius);
    std::vector<Object> tubes;
    while (tubes.size() < count) {
        const auto random = [&](auto& from) {
            const double x = from(rng), y = from(rng), z = from(rng);
            return Vec3(x, y, z);
        };
        const Vec3 point = random(coordinate), axis = random(component);
        const Cylinder tube{point, axis, radius(rng)};
        const bool is_clear = std::ranges::all_of(tubes, [&](const Object& o) {
            const auto& other = std::get<Cylinder>(o);
            const Vec3 across = tube.axis.cross(other.axis).normalized();
            return std::abs(across.dot(tube.point - other.point)) > tube.radius + other.radius + 0.02;
        });
        if (is_clear) tubes.push_back(tube);
    }
    return tubes;
}

}  // namespace vcell
