/// Taylor coefficients along a curve, in interval arithmetic: what certifies a fitted spline.
#pragma once

#include <algorithm>
#include <array>

#include "interval.hpp"

namespace vcell {

/// c_0 + c_1 h + ... + c_4 h^4, cut after order 4. Where the coefficients of the operands enclose those of
/// the expansions at all points of a set, the results do, too [Moore09, sec. 9.3]; c_4 over an interval S is
/// then Lagrange's remainder of the cubic part within S. Unused orders above `degree` are zero and cost
/// nothing.
class Series {
public:
    static constexpr int order = 4;
    using Coefficients = std::array<Interval, order + 1>;

    Series() = default;
    Series(double constant) : c_{Interval(constant)} {}  // NOLINT: numbers are series
    Series(const Interval& constant) : c_{constant} {}   // NOLINT
    Series(const Coefficients& c, int degree) : c_(c), degree_(degree) {}

    const Interval& operator[](int i) const { return c_[i]; }

    friend Series operator-(const Series& a) {
        Series r = a;
        for (int i = 0; i <= a.degree_; ++i) r.c_[i] = -a.c_[i];
        return r;
    }
    friend Series operator+(const Series& a, const Series& b) {
        if (a.degree_ < b.degree_) return b + a;
        Series r = a;
        for (int i = 0; i <= b.degree_; ++i) r.c_[i] += b.c_[i];
        return r;
    }
    friend Series operator-(const Series& a, const Series& b) {
        Series r = a;
        r.degree_ = std::max(a.degree_, b.degree_);
        for (int i = 0; i <= b.degree_; ++i) r.c_[i] -= b.c_[i];
        return r;
    }
    friend Series operator*(const Series& a, const Series& b) {
        Series r;
        r.degree_ = std::min(order, a.degree_ + b.degree_);
        for (int n = 0; n <= r.degree_; ++n) {
            const int first = std::max(0, n - b.degree_), last = std::min(n, a.degree_);
            Interval sum = a.c_[first] * b.c_[n - first];
            for (int i = first + 1; i <= last; ++i) sum += a.c_[i] * b.c_[n - i];
            r.c_[n] = sum;
        }
        return r;
    }
    /// q b = a, order by order.
    friend Series operator/(const Series& a, const Series& b) {
        Series r;
        r.degree_ = b.degree_ == 0 ? a.degree_ : order;
        for (int n = 0; n <= r.degree_; ++n) {
            Interval rest = a.c_[n];
            for (int i = std::max(0, n - b.degree_); i < n; ++i) rest -= r.c_[i] * b.c_[n - i];
            r.c_[n] = rest / b.c_[0];
        }
        return r;
    }
    Series& operator+=(const Series& o) { return *this = *this + o; }
    Series& operator-=(const Series& o) { return *this = *this - o; }
    Series& operator*=(const Series& o) { return *this = *this * o; }

    friend Series square(const Series& a) {
        Series r;
        r.degree_ = std::min(order, 2 * a.degree_);
        for (int n = 0; n <= r.degree_; ++n) {
            Interval sum = n % 2 == 0 ? square(a.c_[n / 2]) : Interval(0.0);
            for (int i = std::max(0, n - a.degree_); 2 * i < n; ++i)
                sum += Interval(2.0) * a.c_[i] * a.c_[n - i];
            r.c_[n] = sum;
        }
        return r;
    }
    /// r r = a, order by order. Pre: a > 0; where a reaches zero the higher orders are unbounded.
    friend Series sqrt(const Series& a) {
        Series r;
        r.degree_ = a.degree_ == 0 ? 0 : order;
        r.c_[0] = sqrt(a.c_[0]);
        const Interval twice = r.c_[0] + r.c_[0];
        for (int n = 1; n <= r.degree_; ++n) {
            Interval rest = a.c_[n];
            for (int i = 1; i < n; ++i) rest -= r.c_[i] * r.c_[n - i];
            r.c_[n] = rest / twice;
        }
        return r;
    }

private:
    Coefficients c_{};
    int degree_ = 0;
};

}  // namespace vcell
