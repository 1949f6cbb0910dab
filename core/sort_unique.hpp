/// Short lists as sets.
#pragma once

#include "platform.hpp"

#include <algorithm>

namespace vcell {

/// Ascending, and each item once.
template <class Items>
void sort_unique(Items& items) {
    // Most are short and in order.
    const auto is_out_of_order = [](const auto& a, const auto& b) { return !(a < b); };
    if (std::adjacent_find(items.begin(), items.end(), is_out_of_order) == items.end()) return;
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());
}

}  // namespace vcell
