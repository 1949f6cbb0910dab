/// Places for words in pictures.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../../primitives/objects/objects.hpp"

namespace vcell {

/// Where a text of that width and height has the most room around its middle, in what closed polygons hold by
/// the even-odd rule; none where it does not fit as far as a grid of places tells.
std::optional<Vec2> place_of_text(std::span<const std::vector<Vec2>> polygons, double width, double height);

/// The largest of 1, 2 and 5 times a power of ten that is no longer than that. Pre: longest > 0.
double round_length(double longest);

}  // namespace vcell
