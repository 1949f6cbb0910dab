/// Polynomials in Bernstein form on [0, 1]: coefficients c[0..n] stand for sum c[i] C(n, i) (1-t)^(n-i) t^i.
///
/// The values over [0, 1] lie in the hull of the coefficients, and a polynomial has at most as many roots in
/// (0, 1) as its coefficients change sign, and as many up to an even number [Farin02, 6].
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "../numbers/exact.hpp"

namespace vcell {

/// The polynomial's blossom at `from` (n - k times) and `to` (k times), with n = c.size() - 1: coefficient k
/// of the same polynomial over [from, to]. De Casteljau. Pre: 0 <= k <= n.
template <class T>
T bernstein_blossom(std::span<const T> c, const T& from, const T& to, std::size_t k) {
    std::vector<T> b(c.begin(), c.end());
    for (std::size_t step = 0; step + 1 < c.size(); ++step) {
        const T& t = step < k ? to : from;
        for (std::size_t i = 0; i + 1 < c.size() - step; ++i) b[i] = (T(1.0) - t) * b[i] + t * b[i + 1];
    }
    return b[0];
}

/// The value at t.
template <class T>
T bernstein_value(std::span<const T> c, const T& t) {
    return bernstein_blossom(c, t, t, 0);
}

/// The coefficients over [from, to].
template <class T>
std::vector<T> bernstein_restricted(std::span<const T> c, const T& from, const T& to) {
    std::vector<T> r;
    for (std::size_t k = 0; k < c.size(); ++k) r.push_back(bernstein_blossom(c, from, to, k));
    return r;
}

/// The product, of degree n = deg p + deg q, times the least common multiple of C(n, 0), ..., C(n, n):
/// without divisions, so exact for exact coefficients. Pre: n <= 32.
std::vector<Exact> bernstein_scaled_product(std::span<const Exact> p, std::span<const Exact> q);
/// The derivative, of degree n - 1. Pre: n >= 1.
std::vector<Exact> bernstein_derivative(std::span<const Exact> c);

/// Where a polynomial changes sign: a root of odd order strictly between the ends, or at both when they are
/// equal.
struct SignChange {
    Exact lower, upper;  ///< dyadic
    Sign after;          ///< the polynomial's sign behind the root
    bool isolated;       ///< proved to be the only root there
};
/// All changes of sign inside (0, 1), ascending. By halving and Descartes' rule, exact. Roots within 2^-depth
/// of each other are not told apart: of those the parity alone counts, and they come with isolated == false.
std::vector<SignChange> bernstein_sign_changes(std::span<const Exact> c, int depth);

}  // namespace vcell
