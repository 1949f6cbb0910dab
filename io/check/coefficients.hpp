/// Bernstein coefficients of polynomials of low degree in plain doubles: lower bounds, and squares.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace vcell::check {

/// Curves and patches of higher degree are not looked at.
inline constexpr int kMost = 5;

/// Bernstein coefficients of a polynomial of degree (m, n).
using Coefficients = std::array<double, (kMost + 1) * (kMost + 1)>;

/// A lower bound of its values: halves are looked at as long as coefficients are far below those at the
/// corners.
inline double least_value(const Coefficients& c, int m, int n, int depth) {
    const int count = (m + 1) * (n + 1);
    const double least = *std::min_element(c.begin(), c.begin() + count);
    const double at_corner =
        std::min({c[0], c[static_cast<std::size_t>(n)], c[static_cast<std::size_t>(m * (n + 1))],
                  c[static_cast<std::size_t>(count - 1)]});
    if (depth == 0 || least >= 0.75 * at_corner) return least;
    const int axis = depth % 2, degree = axis == 0 ? m : n, lines = axis == 0 ? n : m;
    const auto at = [&](Coefficients& x, int line, int i) -> double& {
        return x[static_cast<std::size_t>(axis == 0 ? i * (n + 1) + line : line * (n + 1) + i)];
    };
    Coefficients first = c, second = c;
    for (int line = 0; line <= lines; ++line)
        for (int k = 0; k <= degree; ++k) {
            at(first, line, k) = at(second, line, 0);
            for (int i = 0; i < degree - k; ++i)
                at(second, line, i) = 0.5 * (at(second, line, i) + at(second, line, i + 1));
        }
    return std::min(least_value(first, m, n, depth - 1), least_value(second, m, n, depth - 1));
}

/// binomial(m, i) binomial(n, j), at i (n + 1) + j, by m and n. Known to the compiler: few cells have as many
/// edges as entries.
template <int Most>
struct ProductsOfBinomials {
    static constexpr std::size_t count = Most + 1;
    std::array<std::array<std::array<double, count * count>, count>, count> of{};

    constexpr ProductsOfBinomials() {
        std::array<std::array<double, count>, count> pascal{};
        for (std::size_t n = 0; n < count; ++n)
            for (std::size_t k = 0; k <= n; ++k)
                pascal[n][k] = k == 0 || k == n ? 1 : pascal[n - 1][k - 1] + pascal[n - 1][k];
        for (std::size_t m = 0; m < count; ++m)
            for (std::size_t n = 0; n < count; ++n)
                for (std::size_t i = 0; i <= m; ++i)
                    for (std::size_t j = 0; j <= n; ++j)
                        of[m][n][i * (n + 1) + j] = pascal[m][i] * pascal[n][j];
    }
};
inline constexpr ProductsOfBinomials<kMost> products_of_binomials;
inline constexpr ProductsOfBinomials<2 * kMost> products_of_square;

/// Adds sign a^2, a and r Bernstein coefficients times their binomials, of degrees (M, N) and (2 M, 2 N).
template <int M, int N>
void add_square(double sign, const double* a, double* r) {
    for (int i = 0; i <= M; ++i)
        for (int j = 0; j <= N; ++j) {
            const double x = sign * a[i * (N + 1) + j];
            for (int k = 0; k <= M; ++k)
                for (int l = 0; l <= N; ++l) r[(i + k) * (2 * N + 1) + j + l] += x * a[k * (N + 1) + l];
        }
}
inline void add_square(int m, int n, double sign, const double* a, double* r) {
    if (m == 2 && n == 2) return add_square<2, 2>(sign, a, r);
    if (m == 2 && n == 0) return add_square<2, 0>(sign, a, r);
    for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j)
            for (int k = 0; k <= m; ++k)
                for (int l = 0; l <= n; ++l)
                    r[(i + k) * (2 * n + 1) + j + l] += sign * a[i * (n + 1) + j] * a[k * (n + 1) + l];
}

}  // namespace vcell::check
