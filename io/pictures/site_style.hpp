/// How sites look and are called in pictures, the same in every format.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "../../envelope/cell.hpp"

namespace vcell {

/// Eight light colours as "#rrggbb" that stay apart for colour-blind readers (Paul Tol's "light" scheme,
/// its grey left to the box).
std::span<const std::string_view> palette();

/// Red, green and blue, 0 to 255, of "#rrggbb".
std::array<int, 3> channels(std::string_view colour);

/// A colour of palette() for every object that owns a face. Objects whose faces share an edge differ
/// wherever greedy colouring by last-smallest degree manages with eight colours: always, if the
/// adjacency graph is planar.
std::unordered_map<std::uint32_t, std::size_t> object_colours(const Cell& cell);

/// "object 3 (O1)", "the base", "box side -x", "end +", "the cap".
std::string site_title(const Scene& scene, Site site);

/// The number of the base among the objects; -1 of a scene that does not number it.
std::int32_t base_number(const Scene& scene);

/// "cell 7 (O1)"; below 0 the base has no number.
std::string cell_title(std::int32_t number, const Cell& cell);

}  // namespace vcell
