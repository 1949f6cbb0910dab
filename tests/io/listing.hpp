/// What a certificate leaves unproved, for the messages of tests.
#pragma once

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

}  // namespace vcell
