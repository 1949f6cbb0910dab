#include "raster.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vcell {

namespace {

// The whole numbers in [low, high), and in [0, count).
std::pair<std::size_t, std::size_t> numbers_between(double low, double high, std::size_t count) {
    const auto limited = [&](double x) {
        return static_cast<std::size_t>(std::clamp(std::ceil(x), 0.0, static_cast<double>(count)));
    };
    return {limited(low), limited(high)};
}

}  // namespace

void Raster::cover(std::size_t pixel, double depth, const Colour& colour, float opacity) {
    covers_.push_back({static_cast<float>(depth), colour, opacity, last_[pixel]});
    last_[pixel] = static_cast<std::uint32_t>(covers_.size() - 1);
}

void Raster::triangle(const std::array<Vec3, 3>& corners, const std::array<double, 3>& shades,
                      const Colour& colour, float opacity) {
    const auto& [a, b, c] = corners;
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
    if (area == 0) return;
    const auto [top, bottom] =
        numbers_between(std::min({a.y(), b.y(), c.y()}), std::max({a.y(), b.y(), c.y()}), height_);
    for (std::size_t row = top; row < bottom; ++row) {
        const auto y = static_cast<double>(row);
        // Where the row crosses two of the sides, each half-open, as the row itself is between them.
        double left = INFINITY, right = -INFINITY;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 *p = &corners[k], *q = &corners[(k + 1) % 3];
            if ((p->y() <= y) == (q->y() <= y)) continue;
            if (p->y() > q->y()) std::swap(p, q);  // the same rounding from both triangles
            const double x = p->x() + (y - p->y()) * (q->x() - p->x()) / (q->y() - p->y());
            left = std::min(left, x);
            right = std::max(right, x);
        }
        const auto [begin, end] = numbers_between(left, right, width_);
        for (std::size_t column = begin; column < end; ++column) {
            const auto x = static_cast<double>(column);
            const double u = ((b.x() - x) * (c.y() - y) - (c.x() - x) * (b.y() - y)) / area,
                         v = ((c.x() - x) * (a.y() - y) - (a.x() - x) * (c.y() - y)) / area, w = 1 - u - v;
            const auto shade = static_cast<float>(u * shades[0] + v * shades[1] + w * shades[2]);
            cover(row * width_ + column, u * a.z() + v * b.z() + w * c.z(),
                  {shade * colour[0], shade * colour[1], shade * colour[2]}, opacity);
        }
    }
}

void Raster::line(const Vec3& a, const Vec3& b, double half_width, double nearer, const Colour& colour) {
    const Vec2 along = (b - a).head<2>();
    const double square = along.squaredNorm();
    const auto [top, bottom] =
        numbers_between(std::min(a.y(), b.y()) - half_width, std::max(a.y(), b.y()) + half_width, height_);
    const auto [left, right] =
        numbers_between(std::min(a.x(), b.x()) - half_width, std::max(a.x(), b.x()) + half_width, width_);
    for (std::size_t row = top; row < bottom; ++row)
        for (std::size_t column = left; column < right; ++column) {
            const Vec2 from_a =
                Vec2(static_cast<double>(column), static_cast<double>(row)) - Vec2(a.head<2>());
            const double t = square > 0 ? std::clamp(from_a.dot(along) / square, 0.0, 1.0) : 0.0;
            if ((from_a - t * along).squaredNorm() > half_width * half_width) continue;
            cover(row * width_ + column, a.z() + t * (b.z() - a.z()) + nearer, colour, 1);
        }
}

Colour Raster::seen(std::size_t pixel, std::vector<Cover>& covers) const {
    covers.clear();
    for (std::uint32_t i = last_[pixel]; i != none; i = covers_[i].before) covers.push_back(covers_[i]);
    std::ranges::stable_sort(covers, [](const Cover& p, const Cover& q) { return p.depth > q.depth; });
    Colour result{0, 0, 0};
    float left = 1;
    for (const Cover& c : covers) {
        for (std::size_t k = 0; k < 3; ++k) result[k] += left * c.opacity * c.colour[k];
        left *= 1 - c.opacity;
        if (left == 0) break;
    }
    for (float& channel : result) channel = std::min(1.0F, channel + left);
    return result;
}

Image Raster::image(std::size_t samples) const {
    Image image{width_ / samples, height_ / samples, {}};
    image.bytes.reserve(3 * image.width * image.height);
    std::vector<Cover> covers;
    for (std::size_t y = 0; y < image.height; ++y)
        for (std::size_t x = 0; x < image.width; ++x) {
            Colour sum{0, 0, 0};
            for (std::size_t i = 0; i < samples; ++i)
                for (std::size_t j = 0; j < samples; ++j) {
                    const Colour one = seen((y * samples + i) * width_ + x * samples + j, covers);
                    for (std::size_t k = 0; k < 3; ++k) sum[k] += one[k];
                }
            for (const float channel : sum)
                image.bytes.push_back(static_cast<std::uint8_t>(
                    std::lround(255 * channel / static_cast<float>(samples * samples))));
        }
    return image;
}

}  // namespace vcell
