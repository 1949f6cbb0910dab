/// Parts of rational curves.
#pragma once

#include <algorithm>

#include "bspline.hpp"

namespace vcell {

/// The curve with one more knot at t, the same point for point [Farin02]: Boehm's insertion.
/// Pre: t is in the domain, and fewer times a knot than the degree.
template <int Dim>
RationalCurve<Dim> with_knot(const RationalCurve<Dim>& curve, double t) {
    const auto& [degree, knots, points] = curve;
    const auto at = std::upper_bound(knots.begin(), knots.end(), t);
    const auto k = static_cast<std::size_t>(at - knots.begin()) - 1;
    RationalCurve<Dim> result;
    result.degree = degree;
    result.knots.assign(knots.begin(), at);
    result.knots.push_back(t);
    result.knots.insert(result.knots.end(), at, knots.end());
    for (std::size_t i = 0; i <= points.size(); ++i) {
        if (i + degree <= k || i > k || knots[i] == t) {
            result.points.push_back(points[i + degree <= k ? i : i - 1]);
            continue;
        }
        const double s = (t - knots[i]) / (knots[i + degree] - knots[i]);
        const auto &p = points[i - 1], &q = points[i];
        const double w = (1 - s) * p(Dim) + s * q(Dim);
        auto control = p;
        control.template head<Dim>() = ((1 - s) * p(Dim) * p + s * q(Dim) * q).template head<Dim>() / w;
        control(Dim) = w;
        result.points.push_back(control);
    }
    return result;
}

/// The part of a curve between two parameters, which keep their values.
/// Pre: domain_begin() <= from < to <= domain_end().
template <int Dim>
RationalCurve<Dim> restricted(const RationalCurve<Dim>& curve, double from, double to) {
    const int degree = curve.degree;
    RationalCurve<Dim> all = curve;
    for (const double t : {from, to})
        while (std::count(all.knots.begin(), all.knots.end(), t) < degree) all = with_knot(all, t);
    // With so many knots at t the curve's point there is the control point before the first of them.
    const auto begin = std::upper_bound(all.knots.begin(), all.knots.end(), from) - degree;
    const auto end = std::lower_bound(all.knots.begin(), all.knots.end(), to);
    RationalCurve<Dim> part;
    part.degree = degree;
    part.knots.push_back(from);
    part.knots.insert(part.knots.end(), begin, end + degree);
    part.knots.push_back(to);
    part.points.assign(all.points.begin() + (begin - all.knots.begin() - 1),
                       all.points.begin() + (end - all.knots.begin()));
    return part;
}

}  // namespace vcell
