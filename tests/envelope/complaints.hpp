/// What the tests that judge diagrams by brute force share.
#pragma once

#include <string>
#include <vector>

namespace vcell {

/// A line for each.
inline std::string join(const std::vector<std::string>& lines) {
    std::string s;
    for (const auto& l : lines) s += l + "\n";
    return s;
}

}  // namespace vcell
