/// Integrals along circular arcs and segments, by Gauss-Legendre quadrature with a proven truncation bound.
///
/// On [-1, 1] the n-point rule errs by at most (64/15) M r^(-2n) / (1 - r^-2), where M bounds the integrand
/// on the ellipse with foci +-1 and semi-axes' sum r [Trefethen13, Thm. 19.3]. A span is halved until the
/// integrand is analytic within 2.5 times its half length around its middle; the ellipse with major semi-axis
/// 2.4 lies in that disk, r = 2.4 + sqrt(2.4^2 - 1) > 4.58, and with 16 points the bound is below 4e-21 M.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "chart_arc.hpp"

namespace vcell::quadrature {

inline constexpr int points = 16;              ///< of the rule where none is chosen
inline constexpr double truncation = 4e-21;    ///< error bound over the integrand's bound M
inline constexpr double required_reach = 2.5;  ///< half lengths
/// A span may be halved so often: some forty times for each of many singular points, and into thousands of parts alike
/// where a face is steep all along it.
inline constexpr int most_halvings = 20000;

/// Positive abscissae and their weights; the rule is symmetric.
template <int n>
struct RuleOf {
    static_assert(n % 2 == 0);
    std::array<double, n / 2> x, weight;
};
using Rule = RuleOf<points>;

/// Newton's method on the Legendre polynomial from Chebyshev-like starts; rounding level.
template <int n = points>
const RuleOf<n>& rule() {
    static const RuleOf<n> value = [] {
        RuleOf<n> r;
        for (int i = 0; i < n / 2; ++i) {
            double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 0;
            for (int iteration = 0; iteration < 8; ++iteration) {
                // (k + 1) P_(k+1) = (2k + 1) x P_k - k P_(k-1),  (x^2 - 1) P_n' = n (x P_n - P_(n-1)).
                double previous = 1, p = x;
                for (int k = 1; k < n; ++k) {
                    const double next = ((2 * k + 1) * x * p - k * previous) / (k + 1);
                    previous = p;
                    p = next;
                }
                derivative = n * (x * p - previous) / (x * x - 1);
                x -= p / derivative;
            }
            r.x[i] = x;
            r.weight[i] = 2 / ((1 - x * x) * derivative * derivative);
        }
        return r;
    }();
    return value;
}

/// Seven points of degree 11, among them Gauss's three of degree 5: both rules for one price [Patterson68].
struct NestedRule {
    struct Node {
        double x, weight;  ///< the rule is symmetric
        double gauss;      ///< weight in Gauss's rule, or 0
    };
    double center_weight = 0.450916538658474142, center_gauss = 8.0 / 9;
    std::array<Node, 3> nodes{{{0.434243749346802558, 0.401397414775962223, 0},
                               {0.774596669241483377, 0.268488089868333441, 5.0 / 9},
                               {0.960491268708020283, 0.104656226026467265, 0}}};
};

/// Calls visit(point, step) at the nodes of one span: the sum of g(point) . step approximates the line
/// integral of g. With m the middle of the arc, d the chord and d' the chord turned left, the point at
/// angle a from the middle is m + (sin a d + (1 - cos a) d') / (2 sin half_angle).
template <class Visit>
void visit_nodes(const ArcSpan& span, Visit&& visit) {
    const Rule& r = rule();
    const Eigen::Vector2d middle = span.half_way(), d = span.chord(), left(-d.y(), d.x());
    if (span.half_angle == 0) {
        for (int i = 0; i < points / 2; ++i) {
            const Eigen::Vector2d step = 0.5 * r.weight[i] * d, offset = 0.5 * r.x[i] * d;
            visit(Eigen::Vector2d(middle - offset), step);
            visit(Eigen::Vector2d(middle + offset), step);
        }
        return;
    }
    const double scale = 1 / (2 * std::sin(span.half_angle));
    for (int i = 0; i < points / 2; ++i) {
        const double s = std::sin(0.5 * span.half_angle * r.x[i]),
                     c = std::cos(0.5 * span.half_angle * r.x[i]);
        const double sine = 2 * s * c, versine = 2 * s * s;
        const double w = scale * span.half_angle * r.weight[i];
        const Eigen::Vector2d across = scale * versine * left, along = scale * sine * d;
        const Eigen::Vector2d step_along = w * (1 - versine) * d, step_across = w * sine * left;
        visit(Eigen::Vector2d(middle + across - along), Eigen::Vector2d(step_along - step_across));
        visit(Eigen::Vector2d(middle + across + along), Eigen::Vector2d(step_along + step_across));
    }
}

/// Halves the span until reach(part) >= 2.5 half lengths, then calls visit_part(part, true).
/// reach: a lower bound on the radius (in arc length, about the middle) of analyticity. A singularity on the
/// span itself (an object that all but touches the base there) ends the halving at parts that are 2^-52 of
/// the span: visit_part(part, false), without a bound of the rule's truncation. The same where a budget of
/// halvings is spent, as by numbers that are none.
template <class Reach, class VisitPart>
void visit_parts(const ArcSpan& span, const Reach& reach, VisitPart&& visit_part, int halvings, int& budget) {
    const bool is_tame = 0.5 * span.length() * required_reach <= reach(span);
    if (!is_tame && halvings > 0 && budget > 0) {
        --budget;
        for (const ArcSpan& half : span.halves()) visit_parts(half, reach, visit_part, halvings - 1, budget);
        return;
    }
    visit_part(span, is_tame);
}
template <class Reach, class VisitPart>
void visit_parts(const ArcSpan& span, const Reach& reach, VisitPart&& visit_part) {
    int budget = most_halvings;
    visit_parts(span, reach, visit_part, 52, budget);
}

}  // namespace vcell::quadrature
