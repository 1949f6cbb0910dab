#include "wide.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <limits>

namespace vcell {

namespace {

using Float = Wide::Float;

Float infinite() { return std::numeric_limits<Float>::infinity(); }
Float power_of_two(int exponent) { return ldexp(Float(1), exponent); }

// e with |x| < 2^e.
int exponent_above(const Float& x) {
    if (x == 0) return INT_MIN;
    if (isinf(x)) return INT_MAX;
    return static_cast<int>(x.backend().exponent()) + 1;
}

// Bounds are zero or of magnitude 2^(+-exponent_limit) at most, give or take one rounding. So no
// operation on them leaves the exponent range (about 2^(+-2^30)), and it yields zero only when its
// exact result is zero.
Float up(const Float& x) {
    if (isnan(x)) return infinite();
    if (x == 0) return x;
    if (isinf(x)) return x > 0 ? x : -power_of_two(Wide::exponent_limit);
    const int e = exponent_above(x);
    if (e > Wide::exponent_limit) return x > 0 ? infinite() : -power_of_two(Wide::exponent_limit);
    if (e < -Wide::exponent_limit) return power_of_two(-Wide::exponent_limit);
    return x + ldexp(Float(abs(x)), 2 - Wide::bits);
}
Float down(const Float& x) { return -up(Float(-x)); }

// Within 1.6 u: Newton's method for y = 1 / sqrt(m), x = m 2^e, doubles the digits of a double until half
// of all are known. With r = m y, y (m - r^2) / 2 brings the others; there only the roundings of r^2 and
// of the sum count.
Float root(const Float& x) {
    if (x == 0 || isinf(x)) return x;
    const int e = exponent_above(x) & ~1;
    const Float m = ldexp(x, -e);
    Float y = 1 / std::sqrt(m.convert_to<double>());
    for (int known = 50; known < Wide::bits / 2 + 8; known = 2 * known - 2)
        y += ldexp(Float(y * (1 - m * y * y)), -1);
    const Float r = m * y;
    return ldexp(Float(r + ldexp(Float(y * (m - r * r)), -1)), e / 2);
}

Wide from_candidates(const Float& p, const Float& q, const Float& r, const Float& s) {
    if (isnan(p) || isnan(q) || isnan(r) || isnan(s)) return Wide::whole();
    return {down(std::min(std::min(p, q), std::min(r, s))), up(std::max(std::max(p, q), std::max(r, s)))};
}
Wide scaled(const Wide& a, const Float& factor) {
    const Float p = a.lower() * factor, q = a.upper() * factor;
    return from_candidates(p, q, p, q);
}

// The conversion to double is only a guess: comparing back is exact.
double double_below(const Float& x) {
    if (isinf(x)) return x > 0 ? std::numeric_limits<double>::max() : -HUGE_VAL;
    double d = x.convert_to<double>();
    while (Float(d) > x) d = std::nextafter(d, -HUGE_VAL);
    for (double next = std::nextafter(d, HUGE_VAL); !(Float(next) > x); next = std::nextafter(next, HUGE_VAL))
        d = next;
    return d;
}

}  // namespace

Wide::Wide() : lo_(0), hi_(0) {}
Wide::Wide(double lo, double hi) : Wide(Float(lo), Float(hi)) {}
Wide::Wide(Float lo, Float hi) : lo_(std::move(lo)), hi_(std::move(hi)) {
    if (isnan(lo_) || isnan(hi_)) *this = whole();
}
Wide Wide::whole() { return {-infinite(), infinite()}; }

Wide Wide::mid() const {
    Float m = ldexp(Float(lo_ + hi_), -1);
    m = std::clamp(m, lo_, hi_);
    return {m, m};
}
double Wide::approximation() const { return mid().lo_.convert_to<double>(); }
Interval Wide::enclosure() const { return {double_below(lo_), -double_below(Float(-hi_))}; }
bool Wide::contains(double v) const { return lo_ <= v && v <= hi_; }
bool Wide::contains(const Wide& other) const { return lo_ <= other.lo_ && other.hi_ <= hi_; }

int Wide::magnitude_exponent() const { return std::max(exponent_above(lo_), exponent_above(hi_)); }
int Wide::radius_exponent() const {
    const int e = exponent_above(up(hi_ - lo_));
    return e == INT_MIN || e == INT_MAX ? e : e - 1;
}

std::optional<Sign> Wide::sign() const {
    if (lo_ > 0) return Sign::Positive;
    if (hi_ < 0) return Sign::Negative;
    if (lo_ == 0 && hi_ == 0) return Sign::Zero;
    return std::nullopt;
}

Wide operator-(const Wide& a) { return {Float(-a.hi_), Float(-a.lo_)}; }
Wide operator+(const Wide& a, const Wide& b) { return {down(a.lo_ + b.lo_), up(a.hi_ + b.hi_)}; }
Wide operator-(const Wide& a, const Wide& b) { return {down(a.lo_ - b.hi_), up(a.hi_ - b.lo_)}; }
Wide operator*(const Wide& a, const Wide& b) {
    if (a.lo_ == a.hi_) return scaled(b, a.lo_);
    if (b.lo_ == b.hi_) return scaled(a, b.lo_);
    return from_candidates(a.lo_ * b.lo_, a.lo_ * b.hi_, a.hi_ * b.lo_, a.hi_ * b.hi_);
}
Wide operator*(double s, const Wide& a) { return scaled(a, Float(s)); }
Wide operator/(const Wide& a, const Wide& b) {
    if (b.lo_ <= 0 && b.hi_ >= 0) return Wide::whole();
    if (b.lo_ == b.hi_) {
        const Float p = a.lo_ / b.lo_, q = a.hi_ / b.lo_;
        return from_candidates(p, q, p, q);
    }
    return from_candidates(a.lo_ / b.lo_, a.lo_ / b.hi_, a.hi_ / b.lo_, a.hi_ / b.hi_);
}

Wide Wide::squared() const {
    const Float l = abs(lo_), h = abs(hi_);
    const Float& m = std::max(l, h);
    if (lo_ <= 0 && hi_ >= 0) return {Float(0), up(m * m)};
    const Float& n = std::min(l, h);
    return {std::max(Float(0), down(n * n)), up(m * m)};
}
Wide Wide::square_root() const {
    const Float lo = lo_ > 0 ? down(root(lo_)) : Float(0);
    return {std::max(Float(0), lo), up(root(hi_))};
}
Wide Wide::hull_with(const Wide& other) const { return {std::min(lo_, other.lo_), std::max(hi_, other.hi_)}; }

}  // namespace vcell
