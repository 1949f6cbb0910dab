/// The places of a cell as its file names them.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

#include "../../primitives/objects/site.hpp"

namespace vcell::check {

namespace detail {

/// Every element proved has a path.
inline std::string with_index(std::string list, std::size_t i) {
    list += '[';
    list += std::to_string(i);
    list += ']';
    return list;
}

}  // namespace detail

inline std::string vertex_path(std::size_t i) { return detail::with_index("vertices", i); }
inline std::string edge_path(std::size_t i) { return detail::with_index("edges", i); }
inline std::string face_path(std::size_t i) { return detail::with_index("faces", i); }
inline std::string patch_path(std::size_t f, std::size_t p) {
    return detail::with_index(face_path(f) + ".patches", p);
}
inline std::string loop_path(std::size_t f, std::size_t p, std::size_t l) {
    return detail::with_index(patch_path(f, p) + ".loops", l);
}

inline std::string title(const Site& s) { return s.is_object() ? "object " + to_string(s) : to_string(s); }

inline bool contains(std::span<const Site> sites, const Site& s) {
    return std::ranges::find(sites, s) != sites.end();
}

}  // namespace vcell::check
