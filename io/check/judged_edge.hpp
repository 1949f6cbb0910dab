/// An edge under judgement: whose it is, and its curve in parts.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check.hpp"
#include "middle_planes.hpp"
#include "nets.hpp"
#include "space.hpp"
#include "touching_spheres.hpp"

namespace vcell::check {

struct EdgePart {
    Net net;
    int depth = 0;  // of halving
    std::optional<TouchingSpheres> spheres;
};

struct JudgedEdge {
    std::size_t number = 0;
    std::string path;
    std::vector<Condition> conditions;                        // of its sites, the two sides' first
    std::optional<std::array<MiddlePlane, 2>> middle_planes;  // of its sites, if they have any
    double error = 0;                                         // that of its ends included
    std::vector<EdgePart> parts;                              // one for each span

    /// Halvings after which gradients that are still parallel somewhere are taken to be so at a point.
    static constexpr int kTouching = 12;

    EdgePart part(Net net, int depth, const Space<Interval>& space) const {
        EdgePart result{std::move(net), depth, {}};
        result.spheres = TouchingSpheres::along(result.net, space);
        if (result.spheres)
            for (std::size_t k = 0; k < 2; ++k)
                if (result.spheres->refer_to(conditions[k].site)) break;
        return result;
    }
    /// An edge of many spans gets more, so that each may be divided.
    std::size_t parts_allowed(const CheckOptions& options) const {
        constexpr std::size_t few = 16;
        return (std::size_t{1} << std::clamp(options.effort, 0, 40)) * std::max(parts.size(), few) / few;
    }
};

}  // namespace vcell::check
