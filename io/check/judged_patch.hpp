/// A patch under judgement: whose it is, and how far rounding and the errors of its edges may take it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "check.hpp"
#include "patches.hpp"
#include "tile.hpp"
#include "tips.hpp"
#include "touching_spheres.hpp"

namespace vcell::check {

struct JudgedPatch {
    const Patch& patch;
    std::string where;
    std::vector<Condition> own;              // of the face's sites
    Tile whole;                              // all of it
    std::optional<TouchingSpheres> spheres;  // about it
    std::vector<Tip> tips;                   // of the bisector, if the patch has one
    double width = 0;                        // what rounding of its numbers makes of an excess
    double stated = 0;                       // the largest error of its edges
};

inline std::size_t tiles_allowed(const CheckOptions& options) {
    return std::size_t{16} << std::clamp(options.effort, 0, 40);
}

}  // namespace vcell::check
