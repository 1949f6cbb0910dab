/// What the check says of a cell that was measured.
#pragma once

#include <string>

#include "../io/check/check.hpp"

namespace vcell::bench {

/// The first statement about the cell that is refuted; empty if none is. What the check leaves open at its
/// usual effort is no fault of the cell's.
inline std::string find_refuted(const Cell& cell, std::uint32_t samples) {
    CheckOptions options;
    options.samples = samples;
    for (const Element& e : certify(cell, options).elements)
        if (e.verdict == Verdict::refuted) return e.where + ": " + e.what;
    return {};
}

}  // namespace vcell::bench
