/// Bezier spans joined to curves, and how far they reach: what the lifts over all bases share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "../../core/curves/bspline.hpp"
#include "../../core/sort_unique.hpp"

namespace vcell {

using Range = std::array<double, 2>;  ///< {least, greatest}
constexpr Range empty_range{std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()};

/// Makes knots those of the Bezier pieces from `first` to before `last` of so many of one degree, joined:
/// full and clamped, and of all of them uniform on [0, 1].
inline void join_knots(Knots& knots, int degree, std::size_t spans, std::size_t first, std::size_t last) {
    static constexpr std::array<double, 6> conic{0, 0, 0, 1, 1, 1};
    if (degree == 2 && spans == 1) return knots.assign(conic.begin(), conic.end());
    knots.clear();
    knots.reserve(degree * (last - first + 1) + 2);
    for (std::size_t i = first; i <= last; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(spans);
        knots.insert(knots.end(), i == first || i == last ? degree + 1 : degree, t);
    }
}

/// Makes the curve one of the Bezier pieces from `first` to before `last` of so many, on the knots of all;
/// their control points are still to come.
template <int Dim>
void begin_joined(RationalCurve<Dim>& curve, int degree, std::size_t spans, std::size_t first,
                  std::size_t last) {
    curve.degree = degree;
    join_knots(curve.knots, degree, spans, first, last);
    curve.points.clear();
    curve.points.reserve(degree * (last - first) + 1);
}
/// Makes the curve all of so many Bezier pieces.
template <int Dim>
void begin_joined(RationalCurve<Dim>& curve, int degree, std::size_t spans) {
    begin_joined(curve, degree, spans, 0, spans);
}

/// Extends a range by one coordinate of a rational quadratic with controls a, b, c and weights 1, w, 1.
// In s = 1 - t: N = a s^2 + 2 w b s t + c t^2, D likewise with ones; N' D - N D' is a multiple of
// w (b - a) s^2 + (c - a) s t + w (c - b) t^2, which has a root inside only if b lies outside [a, c]; its
// outer coefficients then differ in sign and exactly one root t : s is positive.
inline void extend(Range& range, double a, double b, double c, double w) {
    range[0] = std::min({range[0], a, c});
    range[1] = std::max({range[1], a, c});
    if (std::min(a, c) <= b && b <= std::max(a, c)) return;
    const double p = w * (b - a), q = c - a, r = w * (c - b);
    const double h = -0.5 * (q + std::copysign(std::sqrt(q * q - 4 * p * r), q));
    const double ratio = std::max(h / r, p / h), s = 1 / (1 + ratio), t = ratio * s;
    const double value = (a * s * s + 2 * w * b * s * t + c * t * t) / (s * s + 2 * w * s * t + t * t);
    range[0] = std::min(range[0], value);
    range[1] = std::max(range[1], value);
}

/// Extends a range by a polynomial with the given Bezier coefficients (degree at most 5), to rounding:
/// divides it where the coefficients reach beyond what its ends have reached. Every second time where a
/// linear derivative with its ends would vanish: near an extremum that soon meets it; halves meet it for
/// certain.
inline void extend_by_polynomial(Range& range, std::span<const double> coefficients, int divisions = 52) {
    range[0] = std::min({range[0], coefficients.front(), coefficients.back()});
    range[1] = std::max({range[1], coefficients.front(), coefficients.back()});
    const auto [low, high] = std::ranges::minmax(coefficients);
    const double slack = 2 * std::numeric_limits<double>::epsilon() * std::max(std::abs(low), std::abs(high));
    if ((low >= range[0] - slack && high <= range[1] + slack) || divisions == 0) return;
    std::array<double, 6> left, right;
    std::ranges::copy(coefficients, right.begin());
    const std::size_t n = coefficients.size() - 1;
    const double first = right[1] - right[0], last = right[n] - right[n - 1];
    const double t = divisions % 2 == 0 && first * last < 0 ? first / (first - last) : 0.5;
    for (std::size_t level = 0; level <= n; ++level) {
        left[level] = right[0];
        for (std::size_t i = 0; i < n - level; ++i) right[i] += t * (right[i + 1] - right[i]);
    }
    extend_by_polynomial(range, {left.data(), n + 1}, divisions - 1);
    extend_by_polynomial(range, {right.data(), n + 1}, divisions - 1);
}

/// Extends a range by a rational curve's coordinate, from values of its control points (degree at most 3) and
/// positive weights: by its hull only where that is no wider than the ends.
inline void extend_by_rational(Range& range, std::span<const double> values, std::span<const double> weights,
                               int divisions = 52) {
    range[0] = std::min({range[0], values.front(), values.back()});
    range[1] = std::max({range[1], values.front(), values.back()});
    const auto [low, high] = std::ranges::minmax(values);
    const double slack = 2 * std::numeric_limits<double>::epsilon() * std::max(std::abs(low), std::abs(high));
    if ((low >= range[0] - slack && high <= range[1] + slack) || divisions == 0) return;
    const std::size_t n = values.size();
    std::array<double, 4> w, v;
    std::array<std::array<double, 4>, 2> part_w, part_v;
    for (std::size_t i = 0; i < n; ++i) {
        w[i] = weights[i];
        v[i] = weights[i] * values[i];
    }
    for (std::size_t level = 0; level < n; ++level) {
        part_w[0][level] = w[0];
        part_v[0][level] = v[0] / w[0];
        part_w[1][n - 1 - level] = w[n - 1 - level];
        part_v[1][n - 1 - level] = v[n - 1 - level] / w[n - 1 - level];
        for (std::size_t i = 0; i + 1 + level < n; ++i) {
            w[i] = 0.5 * (w[i] + w[i + 1]);
            v[i] = 0.5 * (v[i] + v[i + 1]);
        }
    }
    for (const int k : {0, 1})
        extend_by_rational(range, {part_v[k].data(), n}, {part_w[k].data(), n}, divisions - 1);
}

}  // namespace vcell
