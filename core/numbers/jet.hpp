/// Forward automatic differentiation: a value with its N partial derivatives.
///
/// A callable generic in the number type, `std::array<T, M> f(const std::array<T, N>&)`, evaluated on
/// jets yields values and Jacobian at once, with T = double at a point, with T = Interval or Wide an
/// enclosure of both over a box.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "interval.hpp"
#include "wide.hpp"

namespace vcell {

inline double square(double x) { return x * x; }

template <class T, int N>
struct Jet {
    T value{};
    std::array<T, N> gradient{};

    Jet() = default;
    /// A constant.
    Jet(double constant) : value(constant) {}  // NOLINT: numbers are jets
    Jet(const T& constant) requires(!std::is_same_v<T, double>) : value(constant) {}  // NOLINT
    Jet(T v, std::array<T, N> g) : value(std::move(v)), gradient(std::move(g)) {}
    /// The i-th unknown at v.
    static Jet variable(const T& v, int i) {
        Jet x;
        x.value = v;
        x.gradient[i] = T(1.0);
        return x;
    }

    friend Jet operator-(const Jet& a) {
        Jet r;
        r.value = -a.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = -a.gradient[i];
        return r;
    }
    friend Jet operator+(const Jet& a, const Jet& b) {
        Jet r;
        r.value = a.value + b.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = a.gradient[i] + b.gradient[i];
        return r;
    }
    friend Jet operator-(const Jet& a, const Jet& b) {
        Jet r;
        r.value = a.value - b.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = a.gradient[i] - b.gradient[i];
        return r;
    }
    friend Jet operator*(const Jet& a, const Jet& b) {
        Jet r;
        r.value = a.value * b.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = a.gradient[i] * b.value + a.value * b.gradient[i];
        return r;
    }
    /// (a / b)' = (a' - (a / b) b') / b.
    friend Jet operator/(const Jet& a, const Jet& b) {
        Jet r;
        r.value = a.value / b.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = (a.gradient[i] - r.value * b.gradient[i]) / b.value;
        return r;
    }
    Jet& operator+=(const Jet& o) { return *this = *this + o; }
    Jet& operator-=(const Jet& o) { return *this = *this - o; }
    Jet& operator*=(const Jet& o) { return *this = *this * o; }

    friend Jet square(const Jet& a) {
        Jet r;
        r.value = square(a.value);
        const T twice = a.value + a.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = twice * a.gradient[i];
        return r;
    }
    /// Pre: a > 0; over an interval that reaches zero the partials are unbounded.
    friend Jet sqrt(const Jet& a) {
        using std::sqrt;
        Jet r;
        r.value = sqrt(a.value);
        const T twice = r.value + r.value;
        for (int i = 0; i < N; ++i) r.gradient[i] = a.gradient[i] / twice;
        return r;
    }
};

/// The unknowns at x as jets.
template <class T, std::size_t N>
std::array<Jet<T, static_cast<int>(N)>, N> variables(const std::array<T, N>& x) {
    std::array<Jet<T, static_cast<int>(N)>, N> jets;
    for (std::size_t i = 0; i < N; ++i)
        jets[i] = Jet<T, static_cast<int>(N)>::variable(x[i], static_cast<int>(i));
    return jets;
}

/// Values and Jacobian of a system at x: result[k].value = f_k, result[k].gradient[i] = df_k / dx_i.
template <class System, class T, std::size_t N>
auto differentiate(const System& f, const std::array<T, N>& x) {
    return f(variables(x));
}

}  // namespace vcell
