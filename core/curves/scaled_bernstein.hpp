/// Polynomials on [0, 1] in the Bernstein basis, for bounds: a polynomial stays between its smallest and its
/// largest coefficient [Farin02, sec. 5.3].
///
/// Coefficients are kept times their binomials (the scaled basis s^i (1 - s)^(n - i)), in which products are
/// plain convolutions.
#pragma once

#include "../platform.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace vcell {

namespace detail {
template <int N>
constexpr std::array<double, N + 1> binomials() {
    std::array<double, N + 1> row{};
    row[0] = 1;
    for (int k = 1; k <= N; ++k) row[k] = row[k - 1] * (N + 1 - k) / k;
    return row;
}
}  // namespace detail

template <int N>
struct Bernstein {
    std::array<double, N + 1> scaled{};

    /// coefficient(k) for k = 0 .. N, as control points give them.
    template <class F>
    static Bernstein from(F coefficient) {
        Bernstein p;
        for (int k = 0; k <= N; ++k) p.scaled[k] = coefficient(k) * binomial[k];
        return p;
    }
    double coefficient(int k) const { return scaled[k] * reciprocal[k]; }

    /// Upper bound of the absolute value.
    double largest() const {
        double m = 0;
        for (int k = 0; k <= N; ++k) m = std::max(m, std::abs(coefficient(k)));
        return m;
    }
    /// Lower bound of the value.
    double smallest_coefficient() const {
        double m = coefficient(0);
        for (int k = 1; k <= N; ++k) m = std::min(m, coefficient(k));
        return m;
    }

    friend Bernstein operator+(Bernstein p, const Bernstein& q) {
        for (int k = 0; k <= N; ++k) p.scaled[k] += q.scaled[k];
        return p;
    }
    friend Bernstein operator-(Bernstein p, const Bernstein& q) {
        for (int k = 0; k <= N; ++k) p.scaled[k] -= q.scaled[k];
        return p;
    }
    friend Bernstein operator+(Bernstein p, double c) {
        for (int k = 0; k <= N; ++k) p.scaled[k] += c * binomial[k];
        return p;
    }
    friend Bernstein operator-(const Bernstein& p, double c) { return p + -c; }
    friend Bernstein operator*(double c, Bernstein p) {
        for (double& a : p.scaled) a *= c;
        return p;
    }

private:
    static constexpr std::array<double, N + 1> binomial = detail::binomials<N>();
    static constexpr std::array<double, N + 1> reciprocal = [] {
        std::array<double, N + 1> r = detail::binomials<N>();
        for (double& b : r) b = 1 / b;
        return r;
    }();
};

template <int N, int M>
Bernstein<N + M> operator*(const Bernstein<N>& p, const Bernstein<M>& q) {
    Bernstein<N + M> r;
    for (int i = 0; i <= N; ++i)
        for (int j = 0; j <= M; ++j) r.scaled[i + j] += p.scaled[i] * q.scaled[j];
    return r;
}

template <int N>
Bernstein<2 * N> square(const Bernstein<N>& p) {
    Bernstein<2 * N> r;
    for (int i = 0; i <= N; ++i) {
        r.scaled[2 * i] += p.scaled[i] * p.scaled[i];
        const double twice = 2 * p.scaled[i];
        for (int j = i + 1; j <= N; ++j) r.scaled[i + j] += twice * p.scaled[j];
    }
    return r;
}

/// The same polynomial, of degree M formally: times (s + (1 - s))^(M - N).
template <int M, int N>
Bernstein<M> raised(const Bernstein<N>& p) {
    Bernstein<M - N> one;
    one.scaled = detail::binomials<M - N>();
    return p * one;
}

}  // namespace vcell
