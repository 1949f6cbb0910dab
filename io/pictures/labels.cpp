#include "labels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vcell {

namespace {

// How far p is from the polygons' sides, less than nothing outside. Abscissas times `stretch`.
double room(std::span<const std::vector<Vec2>> polygons, const Vec2& p, double stretch) {
    bool is_inside = false;
    double square = INFINITY;
    for (const auto& polygon : polygons)
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            Vec2 a = polygon[i] - p, b = polygon[(i + 1) % polygon.size()] - p;
            a.x() *= stretch;
            b.x() *= stretch;
            if ((a.y() <= 0) != (b.y() <= 0) && a.x() - a.y() * (b.x() - a.x()) / (b.y() - a.y()) > 0)
                is_inside = !is_inside;
            const Vec2 along = b - a;
            const double length = along.squaredNorm(),
                         t = length > 0 ? std::clamp(-a.dot(along) / length, 0.0, 1.0) : 0.0;
            square = std::min(square, (a + t * along).squaredNorm());
        }
    return (is_inside ? 1 : -1) * std::sqrt(square);
}

}  // namespace

std::optional<Vec2> place_of_text(std::span<const std::vector<Vec2>> polygons, double width, double height) {
    Vec2 low = Vec2::Constant(INFINITY), high = -low;
    for (const auto& polygon : polygons)
        for (const Vec2& p : polygon) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
    const Vec2 extent = high - low;
    if (!(extent.x() > width && extent.y() > height)) return std::nullopt;
    // In coordinates in which the text is as high as wide, a circle about it has to fit.
    const double stretch = height / width;
    constexpr int steps = 16, rounds = 4;
    Vec2 best = low + 0.5 * extent;
    double most = room(polygons, best, stretch);
    const auto look_at = [&](const Vec2& p) {
        if (const double here = room(polygons, p, stretch); here > most) {
            most = here;
            best = p;
        }
    };
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j)
            look_at(low + Vec2((i + 0.5) * extent.x() / steps, (j + 0.5) * extent.y() / steps));
    for (int k = 1; k <= rounds; ++k) {
        const Vec2 step = std::ldexp(1.0, -k) * extent / steps, from = best;
        for (const int i : {-1, 0, 1})
            for (const int j : {-1, 0, 1}) look_at(from + Vec2(i * step.x(), j * step.y()));
    }
    return most > 0.6 * height ? std::optional(best) : std::nullopt;
}

double round_length(double longest) {
    const double power = std::pow(10, std::floor(std::log10(longest)));
    for (const double digit : {5.0, 2.0})
        if (digit * power <= longest) return digit * power;
    return power;
}

}  // namespace vcell
