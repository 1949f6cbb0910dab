/// Systems of polynomials given by their monomials.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../numbers/interval.hpp"
#include "../../numbers/jet.hpp"
#include "../../numbers/wide.hpp"

namespace vcell {

/// The tightest enclosure of x^n that its number type gives: even powers are never negative.
template <class T>
T power(const T& x, unsigned n) {
    if (n == 0) return T(1.0);
    if (n % 2 == 0) {
        const T half = power(x, n / 2);
        return n == 2 ? square(x) : square(half);
    }
    return n == 1 ? x : x * power(x, n - 1);
}

/// A coefficient: a double, exact, or an enclosure of a number that is none, such as sqrt(Wide(3.0)).
/// A system whose coefficients are enclosures stands for all systems that they enclose: what is proved,
/// is proved for each of them.
class Coefficient {
public:
    Coefficient(double value) : wide_(value), interval_(value), value_(value) {}  // NOLINT
    Coefficient(Interval i) : wide_(i), interval_(i), value_(i.mid()) {}          // NOLINT
    Coefficient(Wide w)
        : wide_(std::move(w)), interval_(wide_.enclosure()), value_(interval_.mid()) {}  // NOLINT

    /// The enclosure in the arithmetic of T; for double the middle.
    template <class T>
    const auto& in() const {
        if constexpr (std::is_same_v<T, double>)
            return value_;
        else if constexpr (std::is_same_v<T, Wide>)
            return wide_;
        else
            return interval_;
    }

private:
    Wide wide_;
    Interval interval_;
    double value_;
};

/// sum of coefficient * x_0^exponents[0] * ... * x_{N-1}^exponents[N-1].
template <int N>
struct Polynomial {
    struct Term {
        Coefficient coefficient;
        std::array<std::uint8_t, N> exponents;
    };
    std::vector<Term> terms;

    int degree() const {
        int highest = 0;
        for (const Term& t : terms) {
            int d = 0;
            for (const int e : t.exponents) d += e;
            highest = std::max(highest, d);
        }
        return highest;
    }

    template <class T>
    T operator()(const std::array<T, N>& x) const {
        T sum(0.0);
        for (const Term& t : terms) {
            T product(coefficient_in(t, static_cast<T*>(nullptr)));
            for (int i = 0; i < N; ++i)
                if (t.exponents[i] != 0) product *= power(x[i], t.exponents[i]);
            sum += product;
        }
        return sum;
    }

private:
    template <class T>
    static T coefficient_in(const Term& t, T*) {
        return t.coefficient.template in<T>();
    }
    template <class T, int K>
    static T coefficient_in(const Term& t, Jet<T, K>*) {
        return t.coefficient.template in<T>();
    }
};

/// M polynomials in N unknowns; a callable generic in the number type.
template <int M, int N = M>
struct PolynomialSystem {
    std::array<Polynomial<N>, M> equations;

    template <class T>
    std::array<T, M> operator()(const std::array<T, N>& x) const {
        std::array<T, M> values;
        for (int k = 0; k < M; ++k) values[k] = equations[k](x);
        return values;
    }
    int degree() const {
        int highest = 0;
        for (const auto& p : equations) highest = std::max(highest, p.degree());
        return highest;
    }
};

}  // namespace vcell
