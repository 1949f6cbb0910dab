/// How numbers and places are written in messages.
#pragma once

#include <string>

#include "objects.hpp"

namespace vcell {

/// The shortest decimal that reads back as x: "-1", "0.1", "1e+80", "nan".
std::string to_text(double x);

/// "(0.5, 0, 2)"
std::string to_text(const Vec3& p);

}  // namespace vcell
