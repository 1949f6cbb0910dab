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

/// Along a line.
struct LinePlace {
    Vec2 at;
    double degrees;  ///< counter-clockwise, so that letters stand rather up than down
};
/// The middle of a line, if words so wide have room along it and it hardly turns there.
std::optional<LinePlace> place_on_line(std::span<const Vec2> line, double width);

/// Where words are.
class TakenRoom {
public:
    /// Puts words there, unless there are words already: false.
    bool take(const Vec2& middle, const Vec2& room);

private:
    struct Place {
        Vec2 middle, room;
    };
    std::vector<Place> places_;
};

}  // namespace vcell
