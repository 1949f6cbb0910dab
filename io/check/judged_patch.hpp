/// A patch under judgement: whose it is, how far rounding and the errors of its edges may take it, and what
/// is proved of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "room.hpp"
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

/// How far the patch is from its bisector: by what rounding of its numbers makes of zero, or no more than its
/// boundary is, where it is known how far that is from the true one; or, where halves are no nearer to it, by
/// what its edges state. None: that is refuted, or left open.
std::optional<double> certify_on_bisector(const JudgedPatch& judged, const std::optional<double>& boundary,
                                          const Subject& subject, const CheckOptions& options,
                                          Certificate& certificate);

/// Is no site but its own nearer anywhere on a patch that is within `margin` of its bisector?
///
/// On the bisector of site i the excess of a site k has its least value over a face on the face's boundary,
/// where the edges are judged, or at a point where its gradient and that of i's excess are parallel. So
/// beside the boundary nothing has to be resolved: a part of the patch needs no other proof than that the
/// two gradients are nowhere parallel in it, or that k is farther.
bool certify_no_rivals(const JudgedPatch& judged, double margin, const Subject& subject,
                       const CheckOptions& options, Certificate& certificate);

}  // namespace vcell::check
