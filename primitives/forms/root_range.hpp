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

/// The larger roots of C q^2 - 2 B q + A^2 = 0 over ranges of B > 0, A^2 and C > 0, of which all that are
/// asked for have B^2 >= A^2 C: q grows with B and falls as A^2 or C grow. Corners of the ranges beyond that
/// bound it by B / C, which is no more.
template <class T>
T hollow_root_range(const T& B, const T& A2, const T& C) {
    const auto at = [](const T& b, const T& a2, const T& c) {
        const T square_of_root = square(b) - a2 * c;
        return square_of_root.upper() > 0 ? (b + sqrt(square_of_root)) / c : b / c;
    };
    return hull(at(bottom(B), top(A2), top(C)), at(top(B), bottom(A2), bottom(C)));
}

/// The end of A^2's range with which B^2 - A^2 C is greatest where C is least: the sign of C decides.
template <class T>
T with_greatest_root(const T& A2, const T& C) {
    return C.lower() < 0 ? top(A2) : bottom(A2);
}

/// p / sqrt(B^2 - A2 C) over ranges of p, B > 0, A2 and C, of which some is not negative; the whole line
/// where the root may vanish.
template <class T>
T hollow_share(const T& p, const T& B, const T& A2, const T& C) {
    const auto at = [](const T& number, const T& b, const T& a2, const T& c) -> T {
        const T square_of_root = square(b) - a2 * c;
        if (square_of_root.sign() != Sign::Positive) return T::whole();
        return number / sqrt(square_of_root);
    };
    const auto far = [&](const T& number) { return at(number, bottom(B), top(A2), top(C)); };
    const auto near = [&](const T& number) {
        return at(number, top(B), with_greatest_root(A2, C), bottom(C));
    };
    return hull(p.lower() > 0 ? near(bottom(p)) : far(bottom(p)), p.upper() > 0 ? far(top(p)) : near(top(p)));
}

/// The smaller roots of the same over ranges of B > 0, A^2 and C, of any sign, without cancellation: q grows
/// with A^2 and C and falls as B grows, and where corners of the ranges have no root A^2 / B bounds it.
template <class T>
T smaller_root_range(const T& B, const T& A2, const T& C) {
    const auto at = [](const T& b, const T& a2, const T& c) {
        const T square_of_root = square(b) - a2 * c;
        return square_of_root.upper() > 0 ? a2 / (b + sqrt(square_of_root)) : a2 / b;
    };
    return hull(at(top(B), bottom(A2), bottom(C)), at(bottom(B), top(A2), top(C)));
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
