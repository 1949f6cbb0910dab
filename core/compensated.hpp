/// Sums of products of doubles, evaluated as if in twice their precision.
///
/// Coefficients must be within a few roundings of their exact values although their terms cancel. Exact
/// numbers give that in a microsecond each; a compensated sum [ORO05, Algorithm 5.3] in some nanoseconds, as
/// long as no more than 40 bits cancel, and it knows when they do.
#pragma once

#include <cmath>
#include <optional>

namespace vcell {

/// A double and its two halves of at most 26 bits, so that products of halves are exact [ORO05,
/// Algorithm 3.2]. Pre: |x| < 2^996.
struct Halves {
    double value = 0, high = 0, low = 0;

    Halves() = default;
    Halves(double x) : value(x) {  // NOLINT: a double has halves
        const double c = 0x1p27 * x + x;
        high = c - (c - x);
        low = x - high;
    }
    friend Halves operator-(const Halves& x) {
        Halves y;
        y.value = -x.value;
        y.high = -x.high;
        y.low = -x.low;
        return y;
    }
};

/// a - b = high + low, exactly; |low| <= u |high|, u = 2^-53.
struct Difference {
    Halves high;
    double low = 0;

    Difference() = default;
    Difference(double a, double b) : high(a - b) {
        const double z = high.value - a;
        low = (a - (high.value - z)) - (b + z);
    }
    friend Difference operator-(const Difference& d) {
        Difference e;
        e.high = -d.high;
        e.low = -d.low;
        return e;
    }
    double value() const { return high.value; }
};

/// A sum of at most eight products. Pre: factors within 2^(+-500).
class CompensatedSum {
public:
    void add(const Halves& x, const Halves& y) {
        const double p = x.value * y.value;
        add_rounded(p, x.low * y.low - (((p - x.high * y.high) - x.low * y.high) - x.high * y.low));
    }
    void add(const Halves& x, const Difference& d) {
        add(x, d.high);
        low_ += x.value * d.low;
    }
    /// s times the square of d.
    void add_square(double s, const Difference& d) {
        add(s * d.high.value, d.high);
        low_ += s * 2 * d.high.value * d.low;
    }
    void add(const Difference& d) { add_rounded(d.high.value, d.low); }
    CompensatedSum times(const Halves& factor) const {
        CompensatedSum product;
        product.add(factor, Halves(high_));
        product.low_ += factor.value * low_;
        product.size_ = std::abs(factor.value) * size_;
        return product;
    }

    /// Within 1.01 u of the exact value, relatively; none if that cannot be guaranteed.
    ///
    /// Each of the n <= 8 terms is p + e: p is summed with all rounding errors kept (in all at most n u S, S
    /// the sum of all |p|), and low_, of magnitude less than (n + 4) u S, is summed plainly in fewer than 4 n
    /// operations. Dropped squares of low parts and the factor of times() add less than 10 u^2 S. So the
    /// error before the last rounding is below 500 u^2 S, which is less than u / 100 of a value of at least
    /// 2^-36 S.
    std::optional<double> value() const {
        const double v = high_ + low_;
        if (std::abs(v) < 0x1p-36 * size_ || (size_ < 0x1p-600 && size_ != 0)) return std::nullopt;
        return v;
    }

private:
    void add_rounded(double p, double error) {
        const double sum = high_ + p, z = sum - high_;
        low_ += ((high_ - (sum - z)) + (p - z)) + error;
        high_ = sum;
        size_ += std::abs(p);
    }

    double high_ = 0, low_ = 0, size_ = 0;
};

}  // namespace vcell
