/// The sites of a problem's form, to compare with.
#pragma once

#include <vector>

#include "../../primitives/bases/base_problem.hpp"

namespace vcell {

inline std::vector<Site> sites_of(const BaseProblem& problem, FormId f) {
    return {problem.sites[f].begin(), problem.sites[f].end()};
}

}  // namespace vcell
