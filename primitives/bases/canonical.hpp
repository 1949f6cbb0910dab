/// What bringing a scene to canonical position takes over every base.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../objects/exact_space.hpp"
#include "../objects/objects.hpp"
#include "../objects/scene.hpp"
#include "base_problem.hpp"

namespace vcell {

/// A rotation in doubles is off by a few units of 2^-53. Components of a unit vector below that are noise (a
/// cosine of pi/2) where it is rounded anyway: of a cylinder base's axis and of the box's sides over a plane
/// base. That is counted as motion.
inline constexpr double frame_rounding = 0x1p-51;

/// A double's relative error bound only holds above the subnormals; forms stay well clear of them.
inline constexpr double smallest_coefficient = 1e-250;

/// m.p <= k inside, canonical coordinates; m is a unit vector, rounded.
struct BoxSide {
    Vec3 m;
    double k;
    std::uint32_t index;  ///< as in Site::box_side()
};
std::array<BoxSide, 6> canonical_box(const Box& box, const BaseFrame& frame);

/// How far planes within the box have moved as their |n| are told by two doubles, or a bound: that scales
/// distances from them.
double moved_by_length(const Plane& plane, const Box& box);
double moved_by_lengths(const Scene& scene);

/// The axis with its largest component in [1/2, 1): its length drops out of all heights, and products of
/// four lengths and four axis components stay in range. Exact.
Vec3 scaled_axis(const Vec3& axis);

/// A solid ball in some frame.
struct Ball {
    double cx, cy, cz, rho;

    friend bool operator==(const Ball&, const Ball&) = default;
};

/// For each ball the first one equal to it; linear in the number of balls.
std::vector<std::uint32_t> first_equal(std::span<const Ball> balls);

/// Total order of vectors up to positive factors: the first non-zero component's place and sign, then the
/// others' ratios to it.
int compare_rays(std::span<const Exact> p, std::span<const Exact> q);

/// For each vector the first one that is a positive multiple of it.
template <std::size_t N>
std::vector<std::uint32_t> first_equal(const std::vector<std::array<Exact, N>>& rays) {
    std::vector<std::uint32_t> order(rays.size()), first(rays.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t i, std::uint32_t j) { return compare_rays(rays[i], rays[j]) < 0; });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && compare_rays(rays[order[i - 1]], rays[order[i]]) == 0;
        first[order[i]] = same ? first[order[i - 1]] : order[i];
    }
    return first;
}

/// There is no cell: the box `what`.
[[noreturn]] void fail_empty(const std::string& what);

/// "a, b and 7 more": half of a packing may need to be named.
std::string listed(const std::vector<std::string>& items);

}  // namespace vcell
