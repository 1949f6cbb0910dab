#include "labels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace vcell {

namespace {

// How far p is from the polygons' sides, less than nothing outside. Abscissas times `stretch`. Where it is
// less than `wanted`, any such number: most places are told by the first side that is near.
double room(std::span<const std::vector<Vec2>> polygons, const Vec2& p, double stretch, double wanted = 0) {
    const double enough = wanted > 0 ? wanted * wanted * (1 - 1e-12) : 0;
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
            if (square < enough) return std::sqrt(square);
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
        if (const double here = room(polygons, p, stretch, most); here > most) {
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

std::optional<LinePlace> place_on_line(std::span<const Vec2> line, double width) {
    double length = 0;
    for (std::size_t k = 1; k < line.size(); ++k) length += (line[k] - line[k - 1]).norm();
    constexpr double ample = 3, straight = 0.9;
    if (!(length > ample * width)) return std::nullopt;
    const auto at = [&](double distance) {
        for (std::size_t k = 1; k < line.size(); ++k) {
            const double step = (line[k] - line[k - 1]).norm();
            if (distance <= step && step > 0)
                return Vec2(line[k - 1] + distance / step * (line[k] - line[k - 1]));
            distance -= step;
        }
        return line.back();
    };
    const Vec2 along = at(0.5 * (length + width)) - at(0.5 * (length - width));
    if (!(along.norm() > straight * width)) return std::nullopt;
    const double degrees = std::atan2(along.y(), along.x()) * 180 / std::numbers::pi;
    return LinePlace{at(0.5 * length), degrees > 90     ? degrees - 180
                                       : degrees <= -90 ? degrees + 180
                                                        : degrees};
}

// Turned words fit a circle about them.
bool TakenRoom::take(const Vec2& middle, const Vec2& room) {
    constexpr double apart = 0.6;
    for (const Place& place : places_)
        if ((place.middle - middle).norm() < apart * std::max(place.room.maxCoeff() + room.minCoeff(),
                                                              place.room.minCoeff() + room.maxCoeff()))
            return false;
    places_.push_back({middle, room});
    return true;
}

double round_length(double longest) {
    const double power = std::pow(10, std::floor(std::log10(longest)));
    for (const double digit : {5.0, 2.0})
        if (digit * power <= longest) return digit * power;
    return power;
}

}  // namespace vcell
