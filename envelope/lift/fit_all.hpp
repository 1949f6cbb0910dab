/// Fits to the edges of a diagram, which share what they may cost.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "../../core/threads.hpp"
#include "../../primitives/fit/fit_error.hpp"

namespace vcell {

/// fit(i, effort) for all i < count: as one after the other, each with what those before have left. A fit
/// that does not spend all that it is given would not know of more, so threads try each for as much as most
/// need, and what spends that is fitted again in its turn. Pre: fits know nothing of each other.
template <class Fit>
void fit_all(std::size_t count, FitEffort& left, unsigned threads, const Fit& fit) {
    constexpr FitEffort usual{.spans = 500, .cells = 4000};
    std::vector<FitEffort> spent(count, usual);
    if (threads > 1 && count > 1)
        for_all(count, threads, [&](std::size_t i) {
            FitEffort own = usual;
            fit(i, own);
            spent[i] = {usual.spans - own.spans, usual.cells - own.cells};
        });
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_fitted = spent[i].spans < std::min(usual.spans, left.spans) &&
                               spent[i].cells < std::min(usual.cells, left.cells);
        if (is_fitted)
            left = {left.spans - spent[i].spans, left.cells - spent[i].cells};
        else
            fit(i, left);
    }
}

}  // namespace vcell
