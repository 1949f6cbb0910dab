/// How numbers and places are written in messages.
#pragma once

#include <charconv>
#include <string>

#include "objects.hpp"

namespace vcell {

/// The shortest decimal that reads back as x: "-1", "0.1", "1e+80", "nan".
inline std::string to_text(double x) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, x).ptr;
    return {buffer, end};
}

/// "(0.5, 0, 2)"
inline std::string to_text(const Vec3& p) {
    return "(" + to_text(p.x()) + ", " + to_text(p.y()) + ", " + to_text(p.z()) + ")";
}

}  // namespace vcell
