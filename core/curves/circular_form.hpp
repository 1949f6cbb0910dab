/// Functions of the plane whose pairwise comparisons are circles and lines:
///
///     f(x, y) = (k |p - c|^2 + a x + b y + e) / w,      w > 0.
///
/// Two of them are equal on a circle, a line, a point or nowhere: f - g is again of the form
/// K (x^2 + y^2) + A x + B y + C, and three of them at the two points that two such curves share.
#pragma once

#include <cmath>
#include <functional>

#include "../ids.hpp"
#include "../numbers/exact.hpp"

namespace vcell {

struct FormTag {
    static constexpr char letter = 'q';
};
using FormId = Id<FormTag>;

/// f in double. cx, cy and k are exact; a, b, e and w are within 4 u (u = 2^-53) of their exact
/// values, relatively. Either a = b = 0, or cx = cy = 0.
struct CircularForm {
    double k = 0;
    double cx = 0, cy = 0;
    double a = 0, b = 0, e = 0;
    double w = 1;

    /// f(x, y), plain double arithmetic: for output and heuristics only.
    double operator()(double x, double y) const {
        const double dx = x - cx, dy = y - cy;
        return (k * (dx * dx + dy * dy) + a * x + b * y + e) / w;
    }
    /// Numerator and denominator negated: f itself, where w < 0 was to be.
    CircularForm operator-() const { return {-k, cx, cy, -a, -b, -e, -w}; }
};

/// A circular form in the monomial basis over one denominator, as exact predicates take it:
/// f = (K (x^2 + y^2) + A x + B y + C) / W, exact, W > 0.
struct ExactForm {
    Exact K, A, B, C, W;

    ExactForm operator-() const { return {-K, -A, -B, -C, -W}; }
};

/// Functions to compare, with the exact coefficients behind them (computed when asked for).
struct CircularFamily {
    IdVector<FormId, CircularForm> forms;
    std::function<ExactForm(FormId)> exact;
};

}  // namespace vcell
