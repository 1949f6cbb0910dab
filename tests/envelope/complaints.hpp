/// What the tests that judge diagrams by brute force share.
#pragma once

#include <cstdlib>
#include <string>
#include <vector>

namespace vcell {

/// How often random tests repeat: VCELL_TEST_ROUNDS, or once.
inline int rounds() {
    const char* given = std::getenv("VCELL_TEST_ROUNDS");
    return given ? std::stoi(given) : 1;
}

/// A line for each.
inline std::string join(const std::vector<std::string>& lines) {
    std::string s;
    for (const auto& l : lines) s += l + "\n";
    return s;
}

}  // namespace vcell
