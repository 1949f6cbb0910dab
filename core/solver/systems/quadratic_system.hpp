/// Quadratic systems: N equations of degree two at most in N unknowns.
#pragma once

#include <array>
#include <concepts>

#include "../../numbers/interval.hpp"
#include "../../numbers/wide.hpp"
#include "../newton/box.hpp"
#include "polynomial.hpp"

namespace vcell {

/// N quadratic equations in N unknowns,
///     f_k(x) = sum_{i <= j} quadratic[pair(i, j)][k] x_i x_j + sum_i linear[i][k] x_i + constant[k],
/// with coefficients enclosed in T. The index of the equation runs fastest: what is done to one
/// equation is done to all N at once.
template <int N, class T>
struct QuadraticForms {
    static constexpr int pairs = N * (N + 1) / 2;
    /// Pre: i <= j.
    static constexpr int pair(int i, int j) { return i * N - i * (i - 1) / 2 + (j - i); }

    std::array<std::array<T, N>, pairs> quadratic{};
    std::array<std::array<T, N>, N> linear{};
    std::array<T, N> constant{};
};

/// A system that knows its coefficients in both arithmetics.
template <class S, int N>
concept QuadraticSystem = requires(const S& s) {
    { s.template forms<Interval>() } -> std::convertible_to<QuadraticForms<N, Interval>>;
    { s.template forms<Wide>() } -> std::convertible_to<QuadraticForms<N, Wide>>;
};

/// Polynomials of degree two at most as a quadratic system.
template <int N>
struct QuadraticPolynomials {
    const PolynomialSystem<N>& system;  ///< Pre: system.degree() <= 2

    template <class T>
    QuadraticForms<N, T> forms() const {
        QuadraticForms<N, T> q;
        for (int k = 0; k < N; ++k)
            for (const auto& term : system.equations[k].terms) {
                std::array<int, 2> unknowns{};
                int degree = 0;
                for (int i = 0; i < N; ++i)
                    for (int e = 0; e < term.exponents[i]; ++e) unknowns[degree++] = i;
                T& place = degree == 0   ? q.constant[k]
                           : degree == 1 ? q.linear[unknowns[0]][k]
                                         : q.quadratic[q.pair(unknowns[0], unknowns[1])][k];
                place += term.coefficient.template in<T>();
            }
        return q;
    }
};

}  // namespace vcell
