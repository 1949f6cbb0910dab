/// Plain numbers, several at once: loops over them become vector instructions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "midrad.hpp"

namespace vcell::check {

class Lanes {
public:
    static constexpr std::size_t lanes = 4;

    Lanes() = default;
    Lanes(double value) { values_.fill(value); }                // NOLINT: a number
    Lanes(const MidRad& enclosure) : Lanes(enclosure.mid()) {}  // NOLINT: what it encloses, about
    /// f(lane) in each.
    template <class F>
    static Lanes of(const F& f) {
        Lanes r;
        for (std::size_t k = 0; k < lanes; ++k) r.values_[k] = f(k);
        return r;
    }

    double operator[](std::size_t lane) const { return values_[lane]; }
    double sum() const { return (values_[0] + values_[1]) + (values_[2] + values_[3]); }
    /// Not a number if one is none.
    double greatest() const {
        double most = values_[0];
        for (const double x : values_)
            if (!(x <= most)) most = x;
        return most;
    }

    friend Lanes operator-(const Lanes& a) {
        return of([&](std::size_t k) { return -a[k]; });
    }
    friend Lanes operator+(const Lanes& a, const Lanes& b) {
        return of([&](std::size_t k) { return a[k] + b[k]; });
    }
    friend Lanes operator-(const Lanes& a, const Lanes& b) {
        return of([&](std::size_t k) { return a[k] - b[k]; });
    }
    friend Lanes operator*(const Lanes& a, const Lanes& b) {
        return of([&](std::size_t k) { return a[k] * b[k]; });
    }
    friend Lanes operator/(const Lanes& a, const Lanes& b) {
        return of([&](std::size_t k) { return a[k] / b[k]; });
    }
    Lanes& operator+=(const Lanes& o) { return *this = *this + o; }
    friend Lanes square(const Lanes& a) { return a * a; }
    friend Lanes sqrt(const Lanes& a) {
        return of([&](std::size_t k) { return std::sqrt(a[k]); });
    }
    friend Lanes abs(const Lanes& a) {
        return of([&](std::size_t k) { return std::abs(a[k]); });
    }
    /// The second where it is not less or not a number.
    friend Lanes max(const Lanes& a, const Lanes& b) {
        return of([&](std::size_t k) { return b[k] < a[k] ? a[k] : b[k]; });
    }

private:
    std::array<double, lanes> values_{};
};

}  // namespace vcell::check
