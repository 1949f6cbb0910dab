#include "message.hpp"

#include <charconv>

namespace vcell {

std::string to_text(double x) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, x).ptr;
    return {buffer, end};
}

std::string to_text(const Vec3& p) {
    return "(" + to_text(p.x()) + ", " + to_text(p.y()) + ", " + to_text(p.z()) + ")";
}

}  // namespace vcell
