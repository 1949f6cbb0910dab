#include "tube_room.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace vcell::whole {

namespace {

// Sides that are so much farther than what bounds the cell are out of sight.
constexpr double margin = 1.25;

// How far points of the box may be from `point`, along the axes that do not repeat.
Vec3 farthest_in(const Lattice& lattice, const Box& box, const Vec3& point) {
    Vec3 far = (box.max - point).cwiseAbs().cwiseMax((box.min - point).cwiseAbs());
    for (int k = 0; k < 3; ++k)
        if (lattice.repeats(k)) far[k] = 0;
    return far;
}

// No point of the plane across an axis is farther from all of its images in it: not from those that two moves
// make, short ones, which differ in direction.
double farthest_among_images(const Lattice& lattice, const Vec3& direction) {
    constexpr int most = 4;
    constexpr double none = 0x1p-30;  // of the edges: what is along the axis, but for rounding
    const double size = lattice.edges().norm();
    std::vector<Vec3> moves;
    for (int a = -most; a <= most; ++a)
        for (int b = -most; b <= most; ++b)
            for (int c = -most; c <= most; ++c) {
                const std::array<int, 3> edges{a, b, c};
                bool is_image = true;
                for (int k = 0; k < 3; ++k) is_image = is_image && (edges[k] == 0 || lattice.repeats(k));
                const Vec3 by = lattice.edges() * Vec3(a, b, c), move = by - direction.dot(by) * direction;
                if (is_image && move.norm() > none * size) moves.push_back(move);
            }
    if (moves.empty()) return 0;
    const auto is_shorter = [](const Vec3& v, const Vec3& w) { return v.squaredNorm() < w.squaredNorm(); };
    const Vec3 shortest = *std::ranges::min_element(moves, is_shorter);
    for (Vec3& move : moves) move -= move.dot(shortest) / shortest.squaredNorm() * shortest;
    std::erase_if(moves, [&](const Vec3& move) { return !(move.norm() > none * size); });
    const double other = moves.empty() ? 0 : std::ranges::min_element(moves, is_shorter)->norm();
    return 0.5 * std::hypot(shortest.norm(), other);
}

// How long the edges are that repeat, of a box that does not lean.
Vec3 edges_that_repeat(const Lattice& lattice) {
    Vec3 edges = lattice.edges().diagonal();
    for (int k = 0; k < 3; ++k)
        if (!lattice.repeats(k)) edges[k] = 0;
    return edges;
}

}  // namespace

TubeRoom tube_room(const Lattice& lattice, const Box& box, const Cylinder& tube,
                   std::span<const Image> periods, double farthest) {
    const bool closes = !periods.empty();
    const Vec3 along = closes ? lattice.shift(periods.front()) : tube.axis;
    // The axis of the box across which the cell ends: of those that repeat where the tube closes, and
    // otherwise of the others.
    int across = -1;
    for (int k = 0; k < 3; ++k)
        if (lattice.repeats(k) == closes && (across < 0 || std::abs(along[k]) > std::abs(along[across])))
            across = k;
    const Vec3 step = along / along[across];
    double begin = box.min[across], end = box.max[across];
    if (closes) {
        const double first = tube.point[across] + part_before_cut * along[across];
        begin = std::min(first, first + along[across]);
        end = std::max(first, first + along[across]);
    }
    const Vec3 middle = tube.point + (0.5 * (begin + end) - tube.point[across]) * step;

    const Vec3 direction = along.normalized();
    double among_images = farthest_among_images(lattice, direction);
    if (!closes) among_images = std::min(among_images, 0.5 * edges_that_repeat(lattice).norm());
    // The cell reaches so far from the axis, along the box's axes that repeat.
    Vec3 reach = Vec3::Constant(among_images);
    const bool is_upright = lattice.edges().isDiagonal(0), is_along_edge = (step.array() != 0).count() == 1;
    if (is_upright && is_along_edge) reach = 0.5 * lattice.edges().diagonal();
    const double beside =
        std::min(farthest, std::hypot(among_images, farthest_in(lattice, box, middle).norm()));
    reach = reach.cwiseMin(beside);

    const auto around_middle = [&](double half) {
        return std::array<Vec3, 2>{middle - half * step, middle + half * step};
    };
    const double before =
                     margin * beside * std::sqrt(std::max(0.0, 1 - direction[across] * direction[across])),
                 half = 0.5 * (end - begin) + before;
    TubeRoom room{box, around_middle(0.5 * (end - begin)), around_middle(half),
                  std::max(0.0, margin * beside - tube.radius)};
    room.box.min[across] = begin;
    room.box.max[across] = end;
    for (int k = 0; k < 3; ++k) {
        if (!lattice.repeats(k) || (closes && k == across)) continue;
        const double far = margin * (std::abs(step[k]) * half + reach[k]);
        room.box.min[k] = middle[k] - far;
        room.box.max[k] = middle[k] + far;
    }
    return room;
}

}  // namespace vcell::whole
