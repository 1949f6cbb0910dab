/// Sums of products of doubles, evaluated as if in twice their precision.
///
/// Coefficients must be within a few roundings of their exact values although their terms cancel. Exact
/// numbers give that in a microsecond each; a compensated sum [ORO05, Algorithm 5.3] in some nanoseconds, as
/// long as no more than 36 bits cancel, and it knows when they do. T is double, or an Eigen array of doubles:
/// several sums at once.
#pragma once

#include "../platform.hpp"

#include <cmath>
#include <optional>
#include <type_traits>

namespace vcell {

/// A double and its two halves of at most 26 bits, so that products of halves are exact [ORO05,
/// Algorithm 3.2]. Pre: |x| < 2^996.
template <class T = double>
struct Halves {
    T value, high, low;

    Halves(const T& x) : value(x) {  // NOLINT: a number has halves
        const T c = 0x1p27 * x + x;
        high = c - (c - x);
        low = x - high;
    }
};

/// a - b = high + low, exactly; |low| <= u |high|, u = 2^-53.
struct Difference {
    Halves<> high;
    double low;

    Difference(double a, double b) : high(a - b) {
        const double z = high.value - a;
        low = (a - (high.value - z)) - (b + z);
    }
};

/// A sum of at most eight products. Pre: factors within 2^(+-500), or zero.
template <class T = double>
class CompensatedSum {
public:
    CompensatedSum() {
        if constexpr (std::is_same_v<T, double>)
            high_ = low_ = size_ = 0;
        else
            high_ = low_ = size_ = T::Zero();
    }

    void add(const Halves<T>& x, const Halves<>& y) {
        const T p = x.value * y.value;
        add_rounded(p, x.low * y.low - (((p - x.high * y.high) - x.low * y.high) - x.high * y.low));
    }
    void add(const Halves<T>& x, const Difference& d) {
        add(x, d.high);
        low_ += x.value * d.low;
    }
    /// s times the square of d; s is 1 or -1.
    void add_square(double s, const Difference& d) {
        const double h = s * d.high.value;
        add(Halves<T>(h), d.high);
        low_ += 2 * h * d.low;
    }
    CompensatedSum times(const Halves<>& factor) const {
        CompensatedSum product;
        product.add(Halves<T>(high_), factor);
        product.low_ += low_ * factor.value;
        product.size_ = size_ * std::abs(factor.value);
        return product;
    }

    /// Within 1.01 u of the exact value, relatively; none if that cannot be guaranteed.
    ///
    /// Each of the n <= 8 terms is p + e: p is summed with all rounding errors kept (in all at most n u S, S
    /// the sum of all |p|), and low_, of magnitude less than (n + 4) u S, is summed plainly in fewer than 4 n
    /// operations. Dropped products of low parts and the factor of times() add less than 10 u^2 S. So the
    /// error before the last rounding is below 500 u^2 S, which is less than u / 100 of a value of at least
    /// 2^-36 S.
    std::optional<T> value() const {
        const T v = high_ + low_;
        if constexpr (std::is_same_v<T, double>) {
            if (!is_certain(v, size_)) return std::nullopt;
        } else {
            for (int i = 0; i < v.size(); ++i)
                if (!is_certain(v[i], size_[i])) return std::nullopt;
        }
        return v;
    }

private:
    static bool is_certain(double v, double size) {
        // The first rung's bound as value() proves it, and where errors of products cannot underflow.
        constexpr double least_part = 0x1p-36, least_size = 0x1p-600;
        return std::abs(v) >= least_part * size && (size >= least_size || size == 0);
    }

    void add_rounded(const T& p, const T& error) {
        using std::abs;
        const T sum = high_ + p, z = sum - high_;
        low_ += ((high_ - (sum - z)) + (p - z)) + error;
        high_ = sum;
        size_ += abs(p);
    }

    T high_, low_, size_;
};

}  // namespace vcell
