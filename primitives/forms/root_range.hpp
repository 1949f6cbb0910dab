/// Ranges of the root of C q^2 - 2 B q - A^2 = 0 and of what its derivatives are made of, in Interval or
/// Wide.
///
/// Over B, A^2 >= 0 and C > 0 the larger root is monotone, and so is p / sqrt(p^2 + o): the ends of a range
/// are values at ends, of numbers. Of doubles each such value is made of few sums, products, quotients and
/// roots of numbers >= 0, every one of which errs by a part of 2^-53 of itself: a bound on the relative error
/// serves instead of intervals.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/sign.hpp"

namespace vcell {

/// The ends of a range as numbers.
template <class T>
T bottom(const T& t) {
    return {t.lower(), t.lower()};
}
template <class T>
T top(const T& t) {
    return {t.upper(), t.upper()};
}

/// The larger root q of numbers, without cancellation.
template <class T>
T larger_root(const T& B, const T& A2, const T& C) {
    const T R = sqrt(square(B) + A2 * C);
    return B.sign() == Sign::Negative && R.sign() == Sign::Positive ? A2 / (R - B) : (B + R) / C;
}

/// The larger roots q over ranges of B, A^2 and C. Pre: C > 0.
template <class T>
T root_range(const T& B, const T& A2, const T& C) {
    return hull(larger_root(bottom(B), bottom(A2), top(C)), larger_root(top(B), top(A2), bottom(C)));
}

/// p / sqrt(p^2 + o) over ranges of p and o >= 0; where both may vanish, -1 to 1.
template <class T>
T share(const T& p, const T& o) {
    const auto at = [](const T& number, const T& other) {
        const T norm = sqrt(square(number) + other);
        return norm.sign() == Sign::Positive ? number / norm : T(-1.0, 1.0);
    };
    return hull(at(bottom(p), p.lower() > 0 ? top(o) : bottom(o)),
                at(top(p), p.upper() > 0 ? bottom(o) : top(o)));
}

namespace root_range_detail {

// Two roundings of a sum of products, halved by its root, that root, a sum and a quotient: 4 units of 2^-53,
// and one of the end itself. A quotient that underflows errs by half of the least double.
constexpr double error = 0x1p-50;
inline double below(double value) {
    return value - (error * std::abs(value) + std::numeric_limits<double>::denorm_min());
}
inline double above(double value) { return -below(-value); }

// Is this sum of products, or factor of one, so far from over- and underflow that these change nothing?
inline bool is_usual(double value) { return value > 0x1p-900 && value < 0x1p+900; }

}  // namespace root_range_detail

inline Interval root_range(const Interval& B, const Interval& A2, const Interval& C) {
    using namespace root_range_detail;
    const double low = B.lower() * B.lower() + A2.lower() * C.upper(),
                 high = B.upper() * B.upper() + A2.upper() * C.lower();
    if (!is_usual(low) || !is_usual(high) || !is_usual(C.lower()) || !is_usual(C.upper()))
        return root_range<Interval>(B, A2, C);
    const auto root = [](double b, double norm, double a2, double c) {
        return b < 0 ? a2 / (norm - b) : (b + norm) / c;
    };
    const double least = root(B.lower(), std::sqrt(low), A2.lower(), C.upper()),
                 most = root(B.upper(), std::sqrt(high), A2.upper(), C.lower());
    if (!std::isfinite(most)) return root_range<Interval>(B, A2, C);
    return {std::max(0.0, below(least)), above(most)};
}

inline Interval share(const Interval& p, const Interval& o) {
    using namespace root_range_detail;
    const double low = p.lower() * p.lower() + (p.lower() > 0 ? o.upper() : o.lower()),
                 high = p.upper() * p.upper() + (p.upper() > 0 ? o.lower() : o.upper());
    if (!is_usual(low) || !is_usual(high)) return share<Interval>(p, o);
    return {below(p.lower() / std::sqrt(low)), above(p.upper() / std::sqrt(high))};
}

}  // namespace vcell
