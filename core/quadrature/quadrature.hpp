/// Gauss-Legendre quadrature with a proven truncation bound.
///
/// On [-1, 1] the n-point rule errs by at most (64/15) M r^(-2n) / (1 - r^-2), where M bounds the integrand
/// on the ellipse with foci +-1 and semi-axes' sum r [Trefethen13, Thm. 19.3]. A span is halved until the
/// integrand is analytic within 2.5 times its half length around its middle; the ellipse with major semi-axis
/// 2.4 lies in that disk, r = 2.4 + sqrt(2.4^2 - 1) > 4.58, and with 16 points the bound is below 4e-21 M.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "../platform.hpp"

namespace vcell::quadrature {

inline constexpr int points = 16;              ///< of the rule where none is chosen
inline constexpr double truncation = 4e-21;    ///< error bound over the integrand's bound M
inline constexpr double required_reach = 2.5;  ///< half lengths
/// How many times larger that ellipse has to be for rules with six, eight and ten points to err by at most
/// `truncation` M.
struct ShortRules {
    double truncation, six, eight, ten;
};
inline constexpr ShortRules short_rules{1e-17, 6.15, 2.66, 1.63};
/// For integrands that grow fast with the ellipse.
inline constexpr ShortRules tight_rules{truncation, 11.8, 4.31, 2.37};
/// A span may be halved so often: some forty times for each of many singular points, and into thousands of
/// parts alike where a face is steep all along it.
inline constexpr int most_halvings = 20000;

/// Positive abscissae and their weights; the rule is symmetric.
template <int n>
struct RuleOf {
    static_assert(n % 2 == 0);
    std::array<double, n / 2> x, weight;
};
using Rule = RuleOf<points>;

/// By its Taylor series, for starts that a compiler may find: 0 <= x <= pi / 2, rounding level.
constexpr double cosine(double x) {
    double sum = 1;
    for (int k = 26; k >= 2; k -= 2) sum = 1 - x * x / (k * (k - 1)) * sum;
    return sum;
}

/// Newton's method on the Legendre polynomial from Chebyshev-like starts; rounding level.
template <int n>
constexpr RuleOf<n> make_rule() {
    RuleOf<n> r{};
    for (int i = 0; i < n / 2; ++i) {
        double x = cosine(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 0;
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
}
template <int n>
inline constexpr RuleOf<n> rule_of = make_rule<n>();

template <int n = points>
constexpr const RuleOf<n>& rule() {
    return rule_of<n>;
}

/// (k + 1/2) P_k(x) for k = 5: times weights what a node adds to a function's fifth coefficient in the series
/// of Legendre polynomials.
constexpr double fifth_term(double x) {
    const double z = x * x;
    return 5.5 * x * (15 - z * (70 - 63 * z)) / 8;
}

/// Seven points of degree 11, among them Gauss's three of degree 5, and eight more that make them fifteen of
/// degree 23: each rule asks only for what is new [Patterson68].
struct NestedRule {
    struct Node {
        double x, weight;  ///< the rule is symmetric
        double seven = 0;  ///< weight in the rule of seven, or 0
        double gauss = 0;  ///< weight in Gauss's rule, or 0
        double fifth = seven * fifth_term(x);
    };
    Node center{0, 0.2255104997982066874, 0.450916538658474142, 8.0 / 9};
    std::array<Node, 3> first{{{0.434243749346802558, 0.200628529376989021, 0.401397414775962223},
                               {0.774596669241483377, 0.1344152552437842204, 0.268488089868333441, 5.0 / 9},
                               {0.960491268708020283, 0.0516032829970797397, 0.104656226026467265}}};
    std::array<Node, 4> rest{{{0.2233866864289668816, 0.2191568584015874964},
                              {0.6211029467372264029, 0.1715119091363913808},
                              {0.8884592328722569989, 0.09292719531512453769},
                              {0.9938319632127550222, 0.01700171962994026034}}};
};

}  // namespace vcell::quadrature
