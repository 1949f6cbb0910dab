/// What a certificate leaves unproved, for tests.
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "../../io/check/check.hpp"

namespace vcell {

inline std::string listing(const Certificate& certificate) {
    std::string text;
    for (const Element& e : certificate.elements)
        if (e.verdict != Verdict::proved)
            text += e.where + " is " + std::string(to_string(e.verdict)) + ": " + e.what + "\n";
    return text;
}

/// All of it is proved.
inline void check_holds(const Cell& cell) {
    const Certificate certificate = certify(cell);
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
}

}  // namespace vcell
