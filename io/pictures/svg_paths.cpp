#include "svg_paths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace vcell {

namespace {

Vec2 end_point(const Eigen::Vector3d& control_point) { return control_point.head<2>(); }

Vec2 rotated(const Vec2& v) { return {-v.y(), v.x()}; }
double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Of the circle through three points.
std::optional<Vec2> center(const Vec2& a, const Vec2& b, const Vec2& c) {
    const Vec2 p = b - a, q = c - a;
    const double twice = 2 * cross(p, q);
    if (!(std::abs(twice) > 1e-9 * p.norm() * q.norm())) return std::nullopt;
    return a + (rotated(q) * p.squaredNorm() - rotated(p) * q.squaredNorm()) / -twice;
}

}  // namespace

std::string SvgPaths::number(double x) const { return fmt::format("{:.{}g}", x, digits); }
std::string SvgPaths::pair(const Vec2& p) const {
    return fmt::format("{:.{}g},{:.{}g}", p.x(), digits, p.y(), digits);
}
void SvgPaths::move_to(std::string& path, const RationalCurve2& c) const {
    path += fmt::format("M{}", pair(end_point(c.points.front())));
}

void SvgPaths::append(std::string& path, const std::vector<Vec2>& line, const char* close) const {
    for (std::size_t i = 0; i < line.size(); ++i)
        path += fmt::format("{}{}", i == 0 ? 'M' : 'L', pair(line[i]));
    path += close;
}

// Appends the curve to a path that has reached its start.
void SvgPaths::append(std::string& path, const RationalCurve2& c) const {
    const auto degree = static_cast<std::size_t>(c.degree);
    bool bezier_pieces = true;  // every inner knot is there `degree` times
    for (std::size_t i = degree + 1; i + degree < c.points.size() + 1; i += degree)
        bezier_pieces = bezier_pieces && c.knots[i] == c.knots[i + degree - 1];
    bezier_pieces = bezier_pieces && (c.points.size() - 1) % degree == 0;
    for (std::size_t i = degree; i < c.points.size(); ++i) {
        if (c.knots[i] == c.knots[i + 1]) continue;
        // Knot span i; as a Bezier piece its control points are i - degree ... i.
        const bool exact =
            bezier_pieces && append_exact(path, {c.points.begin() + static_cast<std::ptrdiff_t>(i - degree),
                                                 c.points.begin() + static_cast<std::ptrdiff_t>(i) + 1});
        if (!exact) append_cubics(path, c, c.knots[i], c.knots[i + 1], 0);
    }
}

// Lines, parabolas, circular arcs and polynomial cubics have words of their own.
bool SvgPaths::append_exact(std::string& path, const std::vector<Eigen::Vector3d>& p) const {
    const std::size_t degree = p.size() - 1;
    if (degree == 1) {
        path += fmt::format("L{}", pair(end_point(p[1])));
        return true;
    }
    if (degree != 2) return false;
    const Vec2 a = end_point(p[0]), b = end_point(p[1]), c = end_point(p[2]);
    const Vec2 chord = c - a, leg = b - a;
    const double shoulder = p[1].z() / std::sqrt(p[0].z() * p[2].z());
    const double reach = (b - 0.5 * (a + c)).norm();
    if (reach * std::abs(1 - shoulder) < tolerance) {
        path += fmt::format("Q{} {}", pair(b), pair(c));
        return true;
    }
    // An arc of half angle h: an isosceles control triangle with angle h at the chord and shoulder
    // weight cos h; it spans less than a half turn.
    const double cosine = chord.dot(leg) / (chord.norm() * leg.norm());
    const double sine = (leg.x() * chord.y() - leg.y() * chord.x()) / (chord.norm() * leg.norm());
    const bool circular =
        std::abs(leg.norm() - (c - b).norm()) < tolerance && std::abs(shoulder - cosine) * reach < tolerance;
    if (!circular) return false;
    const std::string radius = number(0.5 * chord.norm() / std::abs(sine));
    path += fmt::format("A{} {} 0 0 {} {}", radius, radius, sine > 0 ? 1 : 0, pair(c));
    return true;
}

// Cubic Hermite pieces over [from, to], halved until they follow the curve to the tolerance.
void SvgPaths::append_cubics(std::string& path, const RationalCurve2& c, double from, double to,
                             int depth) const {
    constexpr int deepest = 12;
    const auto [p0, d0] = c.evaluate_with_derivative(from);
    // Just before `to`: at a knot the derivative belongs to the next span.
    const auto [p3, d3] = c.evaluate_with_derivative(std::nextafter(to, from));
    const double h = to - from;
    const Vec2 p1 = p0 + d0 * (h / 3), p2 = p3 - d3 * (h / 3);
    double deviation = 0;
    for (const double s : {0.25, 0.5, 0.75}) {
        const double r = 1 - s;
        const Vec2 q = r * r * r * p0 + 3 * r * r * s * p1 + 3 * r * s * s * p2 + s * s * s * p3;
        deviation = std::max(deviation, (q - c.evaluate(from + s * h)).norm());
    }
    if (deviation > tolerance && depth < deepest) {
        append_cubics(path, c, from, from + 0.5 * h, depth + 1);
        append_cubics(path, c, from + 0.5 * h, to, depth + 1);
        return;
    }
    path += fmt::format("C{} {} {}", pair(p1), pair(p2), pair(p3));
}

/// Every point is tried, and what the circle is known to between them: three of them fix it.
bool SvgPaths::append_arc(std::string& path, const std::vector<Vec2>& line) const {
    const std::size_t n = line.size();
    constexpr std::size_t fewest = 5;
    if (n < fewest) return false;
    const auto middle = center(line[0], line[n / 3], line[2 * n / 3]);
    if (!middle) return false;
    const double radius = (line[0] - *middle).norm();
    for (const Vec2& p : line)
        if (!(std::abs((p - *middle).norm() - radius) <= tolerance)) return false;
    // Arcs of a third of a turn at most.
    double turned = 0;
    for (std::size_t k = 1; k < n; ++k) {
        const Vec2 from = line[k - 1] - *middle, to = line[k] - *middle;
        const double step = std::atan2(cross(from, to), from.dot(to));
        turned += step;
        const bool goes_on = k + 1 < n && std::abs(turned) < std::numbers::pi / 2;
        if (goes_on) continue;
        path += fmt::format("A{} {} 0 0 {} {}", number(radius), number(radius), turned > 0 ? 1 : 0,
                            pair(line[k]));
        turned = 0;
    }
    return true;
}

void SvgPaths::append_smooth(std::string& path, const std::vector<Vec2>& line) const {
    path += fmt::format("M{}", pair(line.front()));
    const Vec2 chord = line.back() - line.front();
    const double length = chord.norm();
    const bool is_straight = length > 0 && std::ranges::all_of(line, [&](const Vec2& p) {
                                 return std::abs(cross(chord, p - line.front())) <= tolerance * length;
                             });
    if (is_straight) {
        path += fmt::format("L{}", pair(line.back()));
    } else if (!append_arc(path, line)) {
        for (std::size_t k = 1; k < line.size(); ++k) path += fmt::format("L{}", pair(line[k]));
    }
}

}  // namespace vcell
