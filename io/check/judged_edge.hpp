/// An edge under judgement: whose it is, its curve in parts, and what is proved of that.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "edges.hpp"
#include "middle_planes.hpp"
#include "nets.hpp"
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

/// How well the curve follows the true arc, within the edge's error all along. None: that is refuted, or left
/// open.
///
/// The excesses of two sites are a map f of space to the plane. Where the least singular value of its
/// derivative is at least s, all within |f| / s of a point, there is a zero that close: the flow of Newton's
/// method, x' = -J^+ f, leads there on a path no longer than that [Deuflhard04, 3.3].
std::optional<EdgeBound> certify_on_arc(const JudgedEdge& edge, const Subject& subject,
                                        const CheckOptions& options, Certificate& certificate);

/// How far from the true boundary a site that is nearer by less than the edge's error tells leaves the curve,
/// which is within `distance` of the arc of its own sites. None: another one is nearer, or may be.
std::optional<double> certify_no_rivals(const JudgedEdge& edge, double distance, const Subject& subject,
                                        const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
