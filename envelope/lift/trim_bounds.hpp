/// Rectangles of parameters that hold trims.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "face_cut.hpp"
#include "joined_spans.hpp"

namespace vcell {

using Rectangle = std::array<Range, 2>;
constexpr Rectangle no_rectangle{empty_range, empty_range};

inline void extend_by_rectangle(Rectangle& box, const Rectangle& other) {
    for (int i = 0; i < 2; ++i) box[i] = {std::min(box[i][0], other[i][0]), std::max(box[i][1], other[i][1])};
}

/// A face thinner than the spacing of doubles still needs a domain that has two ends.
inline void widen(Rectangle& box) {
    for (Range& range : box)
        if (range[0] == range[1])
            range[1] = std::nextafter(range[1], std::numeric_limits<double>::infinity());
}

/// The domain of a patch that holds a loop's trims.
inline Rectangle loop_domain(const std::vector<TrimCurve>& loop) {
    Rectangle box = no_rectangle;
    for (const TrimCurve& trim : loop) extend_by_rectangle(box, curve_bounds(trim.curve));
    widen(box);
    return box;
}

}  // namespace vcell
