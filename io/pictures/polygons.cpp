#include "polygons.hpp"

#include <algorithm>

namespace vcell {

namespace {

double twice_area(const std::vector<LoopPoint>& polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 &p = polygon[i].uv, &q = polygon[(i + 1) % polygon.size()].uv;
        sum += p.x() * q.y() - p.y() * q.x();
    }
    return sum;
}

bool contains(const std::vector<LoopPoint>& polygon, const Vec2& p) {
    bool inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 &a = polygon[i].uv, &b = polygon[(i + 1) % polygon.size()].uv;
        if ((a.y() > p.y()) == (b.y() > p.y())) continue;
        if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
    }
    return inside;
}

}  // namespace

bool proper_crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
    const auto turn = [](const Vec2& p, const Vec2& q, const Vec2& r) {
        return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
    };
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

std::vector<std::uint32_t> crossing_lines(const std::vector<std::vector<LoopPoint>>& polygons) {
    struct Segment {
        Vec2 a, b;
        std::uint32_t line;
        double low() const { return std::min(a.x(), b.x()); }
        double high() const { return std::max(a.x(), b.x()); }
    };
    std::vector<Segment> segments;
    for (const auto& loop : polygons)
        for (std::size_t i = 0; i < loop.size(); ++i)
            segments.push_back({loop[i].uv, loop[(i + 1) % loop.size()].uv, loop[i].line});
    std::sort(segments.begin(), segments.end(),
              [](const auto& s, const auto& t) { return s.low() < t.low(); });
    std::vector<std::uint32_t> lines;
    for (std::size_t i = 0; i < segments.size(); ++i)
        for (std::size_t j = i + 1; j < segments.size() && segments[j].low() <= segments[i].high(); ++j)
            if (proper_crossing(segments[i].a, segments[i].b, segments[j].a, segments[j].b))
                lines.insert(lines.end(), {segments[i].line, segments[j].line});
    return lines;
}

std::vector<std::vector<std::vector<LoopPoint>>> with_holes(std::vector<std::vector<LoopPoint>> polygons) {
    std::vector<std::vector<std::vector<LoopPoint>>> parts;
    std::vector<std::vector<LoopPoint>> holes;
    for (std::vector<LoopPoint>& polygon : polygons) {
        if (twice_area(polygon) > 0)
            parts.emplace_back().push_back(std::move(polygon));
        else
            holes.push_back(std::move(polygon));
    }
    for (const auto& hole : holes)
        for (auto& part : parts)
            if (contains(part.front(), hole.front().uv)) part.push_back(hole);
    return parts;
}

}  // namespace vcell
