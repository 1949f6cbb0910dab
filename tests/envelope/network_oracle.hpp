/// Void networks judged from outside: clearances by brute force, and what percolates through a grid.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <vector>

#include "../../envelope/object_distance.hpp"
#include "../../envelope/whole/void_network.hpp"

namespace vcell::network_oracle {

inline bool encloses(const std::optional<NetworkSphere>& sphere, double diameter) {
    return sphere && std::abs(sphere->diameter - diameter) <= sphere->error + 1e-15;
}

inline Object placed(const DiagramScene& scene, const NetworkSite& site) {
    Object object = scene.objects[site.site.index];
    place_of(object) += scene.edges() * Vec3(site.image[0], site.image[1], site.image[2]);
    return object;
}

/// The clearance by all objects, images about the box included.
inline double clearance(const DiagramScene& scene, const Vec3& p) {
    double least = HUGE_VAL;
    // Boxes that lean have near images farther off.
    const int x = 2 * scene.periodic[0], y = 2 * scene.periodic[1], z = 2 * scene.periodic[2];
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        for (int a = -x; a <= x; ++a)
            for (int b = -y; b <= y; ++b)
                for (int c = -z; c <= z; ++c) {
                    const Object object =
                        placed(scene, {Site::object(i),
                                       {static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                        static_cast<std::int16_t>(c)}});
                    least = std::min(least, distance_from(object, p));
                }
    return least;
}

inline Vec3 wrapped(const DiagramScene& scene, Vec3 p) {
    const Eigen::Matrix3d edges = scene.edges();
    const Vec3 parts = edges.inverse() * (p - scene.box.min);
    for (int k = 0; k < 3; ++k)
        if (scene.periodic[k]) p -= std::floor(parts[k]) * edges.col(k);
    return p;
}

inline std::vector<std::size_t> degrees(const VoidNetwork& network) {
    std::vector<std::size_t> degrees(network.vertices.size(), 0);
    for (const NetworkEdge& e : network.edges)
        if (e.vertices)
            for (const std::uint32_t v : *e.vertices) ++degrees[v];
    return degrees;
}

/// The largest clearance at which cells of a grid over the unit cube percolate along each axis: within half a
/// cell's diagonal of the true one, as clearances change no faster than places.
inline std::array<double, 3> grid_percolation(const DiagramScene& scene, int n) {
    std::vector<double> field(static_cast<std::size_t>(n * n * n));
    for (int i = 0; i < n * n * n; ++i)
        field[static_cast<std::size_t>(i)] = clearance(scene, Vec3(i / (n * n), i / n % n, i % n) / n);
    std::array<double, 3> levels{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    std::vector<int> order(field.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, [&](int a, int b) {
        return field[static_cast<std::size_t>(a)] > field[static_cast<std::size_t>(b)];
    });
    // Whole components are moved when they join: slow, and plain.
    std::vector<int> label(field.size(), -1);
    std::vector<std::array<int, 3>> turn(field.size());
    std::map<int, std::vector<int>> members;
    for (const int i : order) {
        label[static_cast<std::size_t>(i)] = i;
        turn[static_cast<std::size_t>(i)] = {0, 0, 0};
        members[i] = {i};
        const std::array at{i / (n * n), i / n % n, i % n};
        for (int step = 0; step < 27; ++step) {
            std::array<int, 3> to{}, around{};
            for (int k = 0; k < 3; ++k) {
                const int d = k == 0 ? step / 9 - 1 : k == 1 ? step / 3 % 3 - 1 : step % 3 - 1;
                const int next = at[static_cast<std::size_t>(k)] + d;
                around[static_cast<std::size_t>(k)] = next < 0 ? -1 : next >= n ? 1 : 0;
                to[static_cast<std::size_t>(k)] = (next + n) % n;
            }
            const int j = (to[0] * n + to[1]) * n + to[2];
            if (label[static_cast<std::size_t>(j)] < 0 || j == i) continue;
            if (std::ranges::any_of(std::array{0, 1, 2}, [&](int k) {
                    return around[static_cast<std::size_t>(k)] != 0 &&
                           !scene.periodic[static_cast<std::size_t>(k)];
                }))
                continue;
            const auto& ti = turn[static_cast<std::size_t>(i)];
            const auto& tj = turn[static_cast<std::size_t>(j)];
            std::array<int, 3> way{};
            for (std::size_t k = 0; k < 3; ++k) way[k] = ti[k] + around[k] - tj[k];
            const int a = label[static_cast<std::size_t>(i)], b = label[static_cast<std::size_t>(j)];
            if (a == b) {
                for (std::size_t k = 0; k < 3; ++k)
                    if (way[k] != 0) levels[k] = std::max(levels[k], field[static_cast<std::size_t>(i)]);
                continue;
            }
            const bool is_first_smaller = members[a].size() < members[b].size();
            const int from = is_first_smaller ? a : b, into = is_first_smaller ? b : a;
            for (const int m : members[from]) {
                label[static_cast<std::size_t>(m)] = into;
                for (std::size_t k = 0; k < 3; ++k)
                    turn[static_cast<std::size_t>(m)][k] += is_first_smaller ? -way[k] : way[k];
            }
            members[into].insert(members[into].end(), members[from].begin(), members[from].end());
            members.erase(from);
        }
    }
    return levels;
}

inline void check_places(const DiagramScene& scene, const VoidNetwork& network) {
    for (const NetworkVertex& v : network.vertices) {
        const double doubt = v.error + 4 * network.moved + 1e-12;
        CHECK(std::abs(clearance(scene, wrapped(scene, v.point)) - v.clearance) <= doubt);
        for (const NetworkSite& s : v.sites) {
            if (!s.site.is_object()) continue;
            CHECK(std::abs(distance_from(placed(scene, s), v.point) - v.clearance) <= 2 * doubt);
        }
    }
    for (const NetworkEdge& e : network.edges) {
        if (!e.vertices) continue;
        const NetworkVertex &a = network.vertices[(*e.vertices)[0]], &b = network.vertices[(*e.vertices)[1]];
        CHECK(e.bottleneck <= std::min(a.clearance + a.error, b.clearance + b.error) + e.bottleneck_error);
        // Both ends are equally far from the edge's objects, the second one in its image.
        const Vec3 end = b.point + scene.edges() * Vec3(e.image[0], e.image[1], e.image[2]);
        for (const NetworkSite& s : e.sites) {
            if (!s.site.is_object()) continue;
            const Object object = placed(scene, s);
            CHECK(std::abs(distance_from(object, a.point) - a.clearance) < 1e-9);
            CHECK(std::abs(distance_from(object, end) - b.clearance) < 1e-9);
        }
        CHECK((end - a.point).norm() <= e.length + e.length_error + a.error + b.error + 1e-12);
    }
}

}  // namespace vcell::network_oracle
