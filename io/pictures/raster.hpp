/// Pixels that triangles and lines cover, some of them translucent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../../primitives/objects/objects.hpp"

namespace vcell {

/// Rows from the top, three bytes a pixel: red, green, blue.
struct Image {
    std::size_t width = 0, height = 0;
    std::vector<std::uint8_t> bytes;
};

/// Red, green and blue in [0, 1].
using Colour = std::array<float, 3>;

/// Places are x to the right, y downwards and z towards the viewer, in pixels; the middle of the first pixel
/// is the origin. Every pixel keeps all that covers it, so the order of what is drawn does not matter.
class Raster {
public:
    Raster(std::size_t width, std::size_t height)
        : width_(width), height_(height), last_(width * height, none) {}

    /// Shades, one for each corner, multiply the colour and are interpolated. Of two triangles with a common
    /// side each pixel belongs to one.
    void triangle(const std::array<Vec3, 3>& corners, const std::array<double, 3>& shades,
                  const Colour& colour, float opacity);

    /// A stroke of that half width, drawn nearer to the viewer than it is, so that what it bounds does not
    /// hide it.
    void line(const Vec3& a, const Vec3& b, double half_width, double nearer, const Colour& colour);

    /// On white; a pixel of the image is the mean of samples x samples of these. Pre: samples divides width
    /// and height.
    Image image(std::size_t samples) const;

private:
    static constexpr std::uint32_t none = UINT32_MAX;
    struct Cover {
        float depth;
        Colour colour;
        float opacity;
        std::uint32_t before;  // of the same pixel
    };

    void cover(std::size_t pixel, double depth, const Colour& colour, float opacity);
    Colour seen(std::size_t pixel, std::vector<Cover>& covers) const;

    std::size_t width_, height_;
    std::vector<Cover> covers_;
    std::vector<std::uint32_t> last_;  // of each pixel
};

}  // namespace vcell
