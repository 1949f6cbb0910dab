// What decisions in a piece and along its sides have in common.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "dominated.hpp"
#include "mixed_piece.hpp"

namespace vcell {

// Below this exponent, relative to the heights compared, equality is assumed.
inline constexpr int assumed_exponent = -200;

// Stretches shorter than this part of the region are worth more digits: differences that vanish to second
// order drown in a double's rounding there.
inline constexpr double sharp_width = 0x1p-19;

// Are the numbers equal to 200 bits of `scale`?
inline bool agree(const Wide& a, const Wide& b, const Wide& scale) {
    return (a - b).magnitude_exponent() < scale.magnitude_exponent() + assumed_exponent;
}

// The double nearest to a coordinate known to some 2^-240 of the extent: simple ones near zero too.
inline double nearest_double(const Wide& coordinate, double extent) {
    const double grid = std::ldexp(1.0, std::ilogb(extent) + assumed_exponent / 2);
    return std::round(coordinate.approximation() / grid) * grid + 0.0;  // no negative zero
}

inline bool is_point(Interval i) { return i.lower() == i.upper(); }

// The least absolute value that an interval holds.
inline double least_magnitude(const Interval& i) { return std::max({0.0, i.lower(), -i.upper()}); }

// The derivative along d, of a gradient.
inline Interval derivative(const Eigen::Vector2d& d, const std::array<Interval, 2>& gradient) {
    return Interval(d.x()) * gradient[0] + Interval(d.y()) * gradient[1];
}

// Bounds the distance of all points of a box from its middle.
inline double reach(Interval x, Interval y) { return Interval::up(std::hypot(x.radius(), y.radius())); }

// Those of the candidates that may attain the minimum of values enclosed by `value`.
template <class Value>
std::vector<FormId> possibly_lowest(std::span<const FormId> candidates, Value&& value) {
    std::vector<Interval> values;
    double top = infinity;
    for (const FormId f : candidates) {
        values.push_back(value(f));
        top = std::min(top, values.back().upper());
    }
    std::vector<FormId> lowest;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i].lower() <= top) lowest.push_back(candidates[i]);
    return lowest;
}

// Those of the candidates that attain the minimum: compare(f, g) is the exact sign of f - g.
template <class Compare>
std::vector<FormId> exactly_lowest(std::span<const FormId> candidates, Compare&& compare) {
    std::vector<FormId> lowest;
    for (const FormId f : candidates) {
        const Sign s = lowest.empty() ? Sign::Negative : compare(f, lowest.front());
        if (s == Sign::Negative) lowest.clear();
        if (s != Sign::Positive) lowest.push_back(f);
    }
    return lowest;
}

// At a point in doubles.
inline std::vector<FormId> exactly_lowest(const Heights& heights, double x, double y,
                                          std::span<const FormId> candidates, Decisions& decisions) {
    return exactly_lowest(candidates,
                          [&](FormId f, FormId g) { return heights.compare(f, g, x, y, decisions); });
}

}  // namespace vcell
