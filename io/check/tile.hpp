/// Rectangles of a patch that are halved until each is told of, with the sites that may be nearer there.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "least.hpp"
#include "nets.hpp"
#include "patches.hpp"
#include "space.hpp"

namespace vcell::check {

/// A site that may be nearer than the base somewhere, and the only places for that where they are known.
struct Rival {
    Condition condition;
    std::optional<Spots> spots;
};

/// A rectangle of the patch, within the one of its loops.
struct Tile {
    Net net;
    Vec2 lo, hi;  // in the patch's parameters
    std::vector<Rival> rivals;
    double excess = HUGE_VAL;  // a bound on its site's in the tile it is a half of
    int depth = 0;             // of halving
    bool is_inside = false;    // of the loops, as far as is known

    /// Is all within `reach` of a point surely outside, as seen along either parameter? In their directions
    /// tiles hardly overlap, where their boxes may.
    bool misses(const Vec3& point, double reach) const {
        const Sizes& sizes = net.sizes();
        if (!(sizes.least_weight > 0)) return false;
        const Vec3 place = point - net.origin(), corner = net.about(0, 0);
        const std::array<Vec3, 2> ways{net.about(1, 0) - corner, net.about(0, 1) - corner};
        std::array<double, 2> least{HUGE_VAL, HUGE_VAL}, most{-HUGE_VAL, -HUGE_VAL};
        double farthest = 0;
        for (int i = 0; i <= net.degree_s(); ++i)
            for (int j = 0; j <= net.degree_t(); ++j) {
                const Net::Point& p = net.at(i, j);
                const Vec3 q = Vec3(p[0].mid(), p[1].mid(), p[2].mid()) / p[3].mid();
                farthest = std::max(farthest, q.cwiseAbs().sum());
                for (const std::size_t k : {0, 1}) {
                    const double along = ways[k].dot(q);
                    least[k] = std::min(least[k], along);
                    most[k] = std::max(most[k], along);
                }
            }
        const double error = sizes.error[0] + sizes.error[1] + sizes.error[2] + farthest * sizes.error[3];
        const double blur = reach + error / sizes.least_weight +
                            0x1p-48 * (farthest + place.cwiseAbs().sum() + net.origin().cwiseAbs().sum());
        for (const std::size_t k : {0, 1}) {
            const double at = ways[k].dot(place), aside = ways[k].norm() * blur * (1 + 0x1p-40);
            if (at + aside < least[k] || at - aside > most[k]) return true;
        }
        return false;
    }

    /// Which way is longer, between the corners: across that halves are made, but any choice will do.
    int longer_axis() const {
        const Vec3 origin = net.about(0, 0), end = net.about(1, 1);
        const Vec3 along = net.about(1, 0), across = net.about(0, 1);
        return (along - origin).norm() + (end - across).norm() >=
                       (across - origin).norm() + (end - along).norm()
                   ? 0
                   : 1;
    }
    /// The same along the control points of the sides: corners of what bends around a tube may be near each
    /// other.
    int longer_axis_of_sides() const {
        const auto point = [&](int i, int j) {
            const Net::Point& p = net.at(i, j);
            return Vec3(Vec3(p[0].mid(), p[1].mid(), p[2].mid()) / p[3].mid());
        };
        const int m = net.degree_s(), n = net.degree_t();
        double along = 0, across = 0;
        for (int i = 0; i < m; ++i)
            for (const int j : {0, n}) along += (point(i + 1, j) - point(i, j)).norm();
        for (int j = 0; j < n; ++j)
            for (const int i : {0, m}) across += (point(i, j + 1) - point(i, j)).norm();
        return along >= across ? 0 : 1;
    }

    std::array<Tile, 2> halves(int axis) const {
        auto nets = net.halves(axis);
        std::array<Tile, 2> h{Tile{std::move(nets[0]), lo, hi, rivals, excess, depth + 1, is_inside},
                              Tile{std::move(nets[1]), lo, hi, rivals, excess, depth + 1, is_inside}};
        h[0].hi[axis] = h[1].lo[axis] = std::midpoint(lo[axis], hi[axis]);
        return h;
    }
};

/// Is a tile certainly outside the loops? No curve meets it, nor what joins two, and they do not wind
/// around it. If they do, its halves are inside, too. What lies between the curves and the true arcs
/// Faces::check_boundary() answers for: holes far smaller than edges' errors are seen here.
bool is_outside(const Patch& patch, Tile& tile);

}  // namespace vcell::check
