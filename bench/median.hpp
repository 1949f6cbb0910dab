/// The median of measured times.
#pragma once

#include <algorithm>
#include <vector>

namespace vcell::bench {

/// Pre: v is not empty.
inline double median(std::vector<double> v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
}

}  // namespace vcell::bench
