#include "exact.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace vcell {

Exact::Exact() = default;
Exact::Exact(const Exact& other) = default;
Exact::Exact(Exact&& other) noexcept = default;
Exact& Exact::operator=(const Exact& other) = default;
Exact& Exact::operator=(Exact&& other) noexcept = default;
Exact::~Exact() = default;
Exact::Exact(Integer m, long e) : m_(std::move(m)), e_(e) {}

Exact::Exact(double value) {
    assert(std::isfinite(value));
    if (value == 0) return;
    int exponent = 0;
    const double fraction = std::frexp(value, &exponent);  // |fraction| in [1/2, 1)
    auto mantissa = static_cast<long long>(std::ldexp(fraction, 53));
    // Short mantissas keep products short: lattices have coordinates of a few bits.
    const int zeros = __builtin_ctzll(static_cast<unsigned long long>(mantissa));
    m_ = mantissa >> zeros;
    e_ = exponent - 53 + zeros;
}

Exact Exact::sum(const Exact& a, const Exact& b, bool subtract) {
    if (b.m_.is_zero()) return a;
    if (a.m_.is_zero()) return subtract ? -b : b;
    if (a.e_ == b.e_) return Exact(subtract ? Integer(a.m_ - b.m_) : Integer(a.m_ + b.m_), a.e_);
    const long e = std::min(a.e_, b.e_);
    Integer x = a.m_, y = b.m_;
    if (a.e_ > e) x <<= static_cast<unsigned>(a.e_ - e);
    if (b.e_ > e) y <<= static_cast<unsigned>(b.e_ - e);
    return Exact(subtract ? Integer(x - y) : Integer(x + y), e);
}

Exact operator-(const Exact& a) { return Exact(Exact::Integer(-a.m_), a.e_); }
Exact operator+(const Exact& a, const Exact& b) { return Exact::sum(a, b, false); }
Exact operator-(const Exact& a, const Exact& b) { return Exact::sum(a, b, true); }
Exact operator*(const Exact& a, const Exact& b) { return Exact(Exact::Integer(a.m_ * b.m_), a.e_ + b.e_); }
Exact Exact::scaled(long power) const { return Exact(m_, e_ + power); }

long Exact::exponent() const {
    assert(!m_.is_zero());
    return static_cast<long>(msb(abs(m_))) + e_;
}

Interval Exact::enclosure() const {
    if (m_.is_zero()) return Interval(0.0);
    Integer m = abs(m_);
    long e = e_;
    // Cut to 53 bits, and to multiples of the smallest subnormal: then ldexp rounds nothing.
    const long excess = std::max(static_cast<long>(msb(m)) + 1 - 53, -1074 - e);
    bool inexact = false;
    if (excess > 0) {
        inexact = static_cast<long>(lsb(m)) < excess;
        m >>= static_cast<unsigned>(excess);
        e += excess;
    }
    const auto mantissa = static_cast<long long>(m);
    const int scale = static_cast<int>(std::min(e, 5000L));
    double lo = std::ldexp(static_cast<double>(mantissa), scale);
    const double hi = inexact ? std::ldexp(static_cast<double>(mantissa + 1), scale) : lo;
    if (std::isinf(lo)) lo = std::numeric_limits<double>::max();
    return m_.sign() < 0 ? Interval(-hi, -lo) : Interval(lo, hi);
}

std::pair<Exact, Exact> Exact::sqrt_bounds(int bits) const {
    assert(m_.sign() >= 0);
    if (m_.is_zero()) return {Exact(), Exact()};
    // sqrt(m 2^e) = sqrt(m 2^(2k + odd)) 2^((e - odd)/2 - k), integer square root of the first.
    const long odd = ((e_ % 2) + 2) % 2;
    const long have = static_cast<long>(msb(m_)) + 1;
    const long k = std::max(0L, bits + 2 - have / 2);
    const Integer shifted = m_ << static_cast<unsigned>(2 * k + odd);
    Integer rest;
    const Integer root = sqrt(shifted, rest);
    const long e = (e_ - odd) / 2 - k;
    return {Exact(root, e), Exact(rest.is_zero() ? root : Integer(root + 1), e)};
}

void divide_by_common_factor(std::span<Exact> values) {
    Exact::Integer factor = 0;
    long least = std::numeric_limits<long>::max();
    for (Exact& v : values) {
        if (v.m_.is_zero()) continue;
        const unsigned zeros = lsb(abs(v.m_));
        v.m_ /= Exact::Integer(1) << zeros;
        v.e_ += static_cast<long>(zeros);
        least = std::min(least, v.e_);
        factor = gcd(factor, v.m_);
    }
    for (Exact& v : values) {
        if (v.m_.is_zero()) continue;
        if (factor != 1) v.m_ /= factor;
        v.e_ -= least;
    }
}

Sign sign(const OneRoot& v) {
    const Sign sa = v.a.sign();
    const Sign sb = v.b.sign() * v.c.sign();
    if (sb == Sign::Zero) return sa;
    if (sa == Sign::Zero || sa == sb) return sb;
    // Opposite signs: the larger square wins.
    return sa * (v.a * v.a - v.b * v.b * v.c).sign();
}

Sign compare(const OneRoot& p, const Exact& p_den, const OneRoot& q, const Exact& q_den) {
    // sign of u - v with u = (p.a q_den - q.a p_den) + p.b q_den sqrt(p.c), v = q.b p_den sqrt(q.c).
    const OneRoot u{p.a * q_den - q.a * p_den, p.b * q_den, p.c};
    const Exact v = q.b * p_den;
    const Sign su = sign(u);
    const Sign sv = v.sign() * q.c.sign();
    if (sv == Sign::Zero) return su;
    if (su == Sign::Zero || su == -sv) return -sv;
    const OneRoot squares = u * u + -(v * v * q.c);
    return su * sign(squares);
}

Interval enclosure(const OneRoot& v, const Exact& den) {
    assert(den.sign() != Sign::Zero);
    if (sign(v) == Sign::Zero) return Interval(0.0);
    // Numerator and denominator may lie outside the range of doubles while their quotient does not:
    // scale both by the power of two that brings the denominator to [1, 2).
    const long shift = -den.exponent();
    const Interval d = den.scaled(shift).enclosure();
    const Exact a = v.a.scaled(shift), b = v.b.scaled(shift);
    if (b.sign() == Sign::Zero || v.c.sign() == Sign::Zero) return a.enclosure() / d;
    const bool up = b.sign() == Sign::Positive;
    for (int bits = 128;; bits *= 2) {
        const auto [root_lo, root_hi] = v.c.sqrt_bounds(bits);
        const Interval lo = (a + b * (up ? root_lo : root_hi)).enclosure();
        const Interval hi = (a + b * (up ? root_hi : root_lo)).enclosure();
        const Interval n(lo.lower(), hi.upper());
        // Cancellation between a and b sqrt(c) shows as width: ask the root for more bits. The value
        // is not zero, so this ends.
        constexpr double width = 0x1p-50;  // as a part of it: after the division within the 16 ulp promised
        if (n.sign() && n.upper() - n.lower() <= width * n.magnitude()) return n / d;
        if (n.magnitude() < std::numeric_limits<double>::min()) return n / d;
    }
}

}  // namespace vcell
