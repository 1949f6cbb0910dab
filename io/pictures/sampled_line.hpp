/// Edges of a mesh's cell, and seams and tips of its patches, as polylines.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "../../core/curves/bspline.hpp"

namespace vcell {

// Parameters agree to this part of a line's length: places that trimming curves of one line share were
// rounded on the way from one to the other.
inline constexpr double break_rounding = 1e-12;

/// A cell edge or a seam as a polyline: parameters, ends included, and mesh points. A seam has those of the
/// first trimming curve along it; the other one runs against it.
struct SampledLine {
    std::vector<double> parameters;
    std::vector<std::uint32_t> points;
    // Where the first and last point of a closed line is, if not where the curve begins.
    std::optional<double> closing_parameter;
};

// A line has a point at each break: the nearest one, or where that stands for another break or an end, this
// point once more.
inline void break_up(SampledLine& s, const std::vector<double>& breaks) {
    std::vector<bool> is_break(s.points.size(), false);
    is_break.front() = is_break.back() = true;
    for (std::size_t k = 1; k + 1 < breaks.size(); ++k) {
        const double at = breaks[k];
        auto i = std::ranges::lower_bound(s.parameters, at) - s.parameters.begin();
        if (at - s.parameters[i - 1] < s.parameters[i] - at) --i;
        if (!is_break[i]) {
            s.parameters[i] = at;
            is_break[i] = true;
            continue;
        }
        const auto place = s.parameters[i] < at ? i + 1 : i;
        s.points.insert(s.points.begin() + place, s.points[i]);
        s.parameters.insert(s.parameters.begin() + place, at);
        is_break.insert(is_break.begin() + place, true);
    }
}

// In order; those that mean the same place differ by their rounding.
inline void settle_breaks(std::vector<double>& breaks) {
    std::sort(breaks.begin(), breaks.end());
    const double apart = break_rounding * (breaks.back() - breaks.front());
    std::vector<double> settled;
    for (const double t : breaks)
        if (settled.empty() || t - settled.back() > apart) settled.push_back(t);
    settled.back() = breaks.back();
    breaks = std::move(settled);
}

// The parameter at which a curve is that runs back along another one, whatever their domains.
inline double mirrored(const RationalCurve2& from, const RationalCurve2& to, double t) {
    const double s = (t - from.domain_begin()) / (from.domain_end() - from.domain_begin());
    return s <= 0   ? to.domain_end()
           : s >= 1 ? to.domain_begin()
                    : to.domain_end() - s * (to.domain_end() - to.domain_begin());
}

}  // namespace vcell
