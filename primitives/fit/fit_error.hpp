/// What a fit (spline_fit.hpp) may cost, and how near it came.
#pragma once

#include <cstddef>
#include <optional>

#include "../objects/objects.hpp"

namespace vcell {

struct SpaceFitError {
    /// Of the curve (x, y, z, t) from the arc; infinite if it is not proved.
    double curve = 0;
    /// Of the patches' points at the trims from the space curve at the same parameter.
    double trims = 0;
    std::optional<Vec3> unproved = {};  ///< where one of them is infinite
    Vec3 worst = Vec3::Zero();          ///< where they are largest
};

/// What fits may still cost. When it is spent spans stay as they are.
struct FitEffort {
    std::size_t spans = 20'000;   ///< that are tried
    std::size_t cells = 400'000;  ///< of the chart where arcs are looked for
};

}  // namespace vcell
