// What is certainly above another one is lowest nowhere.
#pragma once

#include "../../core/platform.hpp"

#include <cstddef>
#include <utility>

namespace vcell {

// More items than this are not compared with each other: pairs would take longer than what they spare.
inline constexpr std::size_t most_compared_in_pairs = 16;

// Removes it; certainly_above(a, b): is a above b wherever both are compared?
template <class Items, class Above>
void drop_dominated(Items& items, Above&& certainly_above) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
        bool above = false;
        for (std::size_t j = 0; j < items.size() && !above; ++j)
            above = j != i && certainly_above(items[i], items[j]);
        if (!above) std::swap(items[kept++], items[i]);
    }
    items.resize(kept);
}

}  // namespace vcell
