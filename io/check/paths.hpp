/// The places of a cell as its file names them.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

#include "../../primitives/site.hpp"

namespace vcell::check {

inline std::string vertex_path(std::size_t i) { return fmt::format("vertices[{}]", i); }
inline std::string edge_path(std::size_t i) { return fmt::format("edges[{}]", i); }
inline std::string face_path(std::size_t i) { return fmt::format("faces[{}]", i); }
inline std::string patch_path(std::size_t f, std::size_t p) {
    return fmt::format("faces[{}].patches[{}]", f, p);
}
inline std::string loop_path(std::size_t f, std::size_t p, std::size_t l) {
    return fmt::format("faces[{}].patches[{}].loops[{}]", f, p, l);
}

inline std::string title(const Site& s) { return s.is_object() ? "object " + to_string(s) : to_string(s); }

inline bool contains(std::span<const Site> sites, const Site& s) {
    return std::ranges::find(sites, s) != sites.end();
}

}  // namespace vcell::check
