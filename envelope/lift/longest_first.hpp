/// Curves that are proved part by part.
#pragma once

#include "../../core/platform.hpp"

#include <queue>
#include <utility>
#include <vector>

namespace vcell {

/// Halves what of a curve is not proved, the longest part first, `depth` times each and `halvings` times in
/// all at most, and returns the length of what is left. A part along a bend that rounding hides is never
/// proved: taken in order, its halves would leave none for those that come later. Calls prove(part), which
/// says whether it is; parts tell their length() and halves().
template <class Part, class Prove>
double unproved_length(std::vector<Part> parts, int depth, int halvings, Prove&& prove) {
    struct Open {
        Part part;
        double length;
        int depth;

        bool operator<(const Open& o) const { return length < o.length; }
    };
    std::priority_queue<Open> open;
    const auto place = [&](Part part, int deeper) {
        if (prove(part)) return;
        const double length = part.length();
        open.push({std::move(part), length, deeper});
    };
    for (Part& part : parts) place(std::move(part), depth);
    double rest = 0;
    while (!open.empty()) {
        const Open longest = open.top();
        open.pop();
        if (longest.depth == 0 || halvings == 0) {
            rest += longest.length;
            continue;
        }
        --halvings;
        for (Part& half : longest.part.halves()) place(std::move(half), longest.depth - 1);
    }
    return rest;
}

}  // namespace vcell
