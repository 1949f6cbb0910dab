/// Symmetric quadrature rules, and their points some at a time: roots and quotients of several registers take
/// hardly longer than those of one.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "../../core/quadrature/quadrature.hpp"

namespace vcell {

/// The positive points of a rule, which is symmetric, and their weights.
struct HalfRule {
    std::span<const double> x, weight;

    static constexpr int most_points = 20;
    /// Pre: the number of points is even, 4 at least and no more than most_points.
    static const HalfRule& of(int points);

    /// Values at three pairs of points that are as far from the middle.
    static constexpr std::size_t pairs_at_once = 3;
    using Values = Eigen::Array<double, 2 * static_cast<int>(pairs_at_once), 1>;
    struct Group {
        Values s = Values::Zero(), weight = Values::Zero();
    };
    /// The pairs from `first` on; what is left over of the last group has no weight.
    Group group(std::size_t first) const {
        Group result;
        const std::size_t end = std::min(first + pairs_at_once, x.size());
        for (std::size_t k = first; k < end; ++k) {
            const auto at = static_cast<Eigen::Index>(2 * (k - first));
            result.s[at] = -x[k];
            result.s[at + 1] = x[k];
            result.weight[at] = result.weight[at + 1] = weight[k];
        }
        return result;
    }
};

namespace half_rules {

template <int n>
constexpr HalfRule rule() {
    return {quadrature::rule<n>().x, quadrature::rule<n>().weight};
}
inline constexpr std::array<HalfRule, 9> all{rule<4>(),  rule<6>(),  rule<8>(),
                                             rule<10>(), rule<12>(), rule<14>(),
                                             rule<16>(), rule<18>(), rule<HalfRule::most_points>()};

}  // namespace half_rules

inline const HalfRule& HalfRule::of(int points) {
    return half_rules::all[static_cast<std::size_t>(points / 2 - 2)];
}

}  // namespace vcell
