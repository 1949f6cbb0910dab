/// Plain numbers, several at once, in vector instructions: compilers find few of them in loops over arrays.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "midrad.hpp"

namespace vcell::check {

class Lanes {
public:
    static constexpr std::size_t lanes = 4;

    Lanes() = default;
    Lanes(double value) : values_{Pair{value, value}, Pair{value, value}} {}  // NOLINT: a number
    Lanes(const MidRad& enclosure) : Lanes(enclosure.mid()) {}  // NOLINT: what it encloses, about
    /// f(lane) in each.
    template <class F>
    static Lanes of(const F& f) {
        Lanes r;
        for (std::size_t k = 0; k < lanes; ++k) r.values_[k / 2][k % 2] = f(k);
        return r;
    }

    double operator[](std::size_t lane) const { return values_[lane / 2][lane % 2]; }
    double sum() const { return ((*this)[0] + (*this)[1]) + ((*this)[2] + (*this)[3]); }
    /// Not a number if one is none.
    double greatest() const {
        double most = (*this)[0];
        for (std::size_t k = 1; k < lanes; ++k)
            if (!((*this)[k] <= most)) most = (*this)[k];
        return most;
    }
    double least() const {
        return std::min(std::min((*this)[0], (*this)[1]), std::min((*this)[2], (*this)[3]));
    }

    friend Lanes operator-(const Lanes& a) { return {-a.values_[0], -a.values_[1]}; }
    friend Lanes operator+(const Lanes& a, const Lanes& b) {
        return {a.values_[0] + b.values_[0], a.values_[1] + b.values_[1]};
    }
    friend Lanes operator-(const Lanes& a, const Lanes& b) {
        return {a.values_[0] - b.values_[0], a.values_[1] - b.values_[1]};
    }
    friend Lanes operator*(const Lanes& a, const Lanes& b) {
        return {a.values_[0] * b.values_[0], a.values_[1] * b.values_[1]};
    }
    friend Lanes operator/(const Lanes& a, const Lanes& b) {
        return {a.values_[0] / b.values_[0], a.values_[1] / b.values_[1]};
    }
    Lanes& operator+=(const Lanes& o) { return *this = *this + o; }
    friend Lanes square(const Lanes& a) { return a * a; }
    friend Lanes sqrt(const Lanes& a) { return {root(a.values_[0]), root(a.values_[1])}; }
    friend Lanes abs(const Lanes& a) { return {size(a.values_[0]), size(a.values_[1])}; }
    /// The second where it is not less or not a number.
    friend Lanes max(const Lanes& a, const Lanes& b) {
        return {greater(a.values_[0], b.values_[0]), greater(a.values_[1], b.values_[1])};
    }
    friend Lanes min(const Lanes& a, const Lanes& b) {
        return {lesser(a.values_[0], b.values_[0]), lesser(a.values_[1], b.values_[1])};
    }

private:
    /// Two doubles, as many as a register of any processor's holds.
    using Pair [[gnu::vector_size(16)]] = double;

    Lanes(Pair first, Pair second) : values_{first, second} {}
#if defined(__SSE2__)
    static Pair size(Pair x) { return _mm_andnot_pd(_mm_set1_pd(-0.0), x); }
    static Pair root(Pair x) { return _mm_sqrt_pd(x); }
    static Pair greater(Pair a, Pair b) { return _mm_max_pd(a, b); }
    static Pair lesser(Pair a, Pair b) { return _mm_min_pd(a, b); }
#else
    static Pair size(Pair x) { return x < 0 ? -x : x; }
    static Pair root(Pair x) { return {std::sqrt(x[0]), std::sqrt(x[1])}; }
    static Pair greater(Pair a, Pair b) { return a > b ? a : b; }
    static Pair lesser(Pair a, Pair b) { return a < b ? a : b; }
#endif

    Pair values_[2]{};
};

}  // namespace vcell::check
