/// The zero of a function of one variable, by interval Newton steps and bisection.
#pragma once

#include <algorithm>
#include <cmath>

#include "../../numbers/interval.hpp"
#include "../../numbers/wide.hpp"

namespace vcell {

/// `a` without what lies outside b; where nothing remains, the end of `a` next to b.
template <class T>
T clamped(const T& a, const T& b) {
    const auto lo = std::clamp(b.lower(), a.lower(), a.upper());
    const auto hi = std::clamp(b.upper(), a.lower(), a.upper());
    return T(lo, hi);
}

namespace detail {

/// The spacing of numbers near 1, with a few bits to spare for the arithmetic.
template <class T>
inline const double last_bit = 0x1p-51;
template <>
inline const double last_bit<Wide> = 0x1p-312;

inline double magnitude(double bound) { return std::abs(bound); }
inline Wide::Float magnitude(const Wide::Float& bound) { return abs(bound); }

}  // namespace detail

/// Shrinks `bracket` about the one zero of an increasing function f until no more can be told.
///
/// Interval Newton steps where the derivative is positive all over the bracket, bisection elsewhere. value(m)
/// encloses f(m), or for a family of functions all its values at m: then all their zeros are enclosed; it may
/// be the whole line where f cannot be evaluated. slope(X) encloses f' over X. f need not increase away from
/// its zero, as long as it is negative left and positive right of it wherever value() answers. Without a zero
/// in the bracket: the end of it next to the zero of a continuation of f.
template <class T, class Value, class Slope>
T enclose_zero(T bracket, const Value& value, const Slope& slope) {
    const auto point = [](const auto& bound) { return T(bound, bound); };
    const auto width = [](const T& t) { return t.upper() - t.lower(); };
    // Below the last bits of the bracket's ends nothing is gained, and a zero at 0 would never end.
    const auto least = std::max(detail::magnitude(bracket.lower()), detail::magnitude(bracket.upper())) *
                       detail::last_bit<T>;
    while (width(bracket) > least) {
        const T middle(bracket.mid());
        const T at_middle = value(middle);
        T next = bracket;
        if (at_middle.lower() > 0) next = T(next.lower(), middle.lower());
        if (at_middle.upper() < 0) next = T(middle.upper(), next.upper());
        if (const T s = slope(bracket); s.lower() > 0) next = clamped(next, middle - at_middle / s);
        if (!(width(next) <= width(bracket) * 0.75)) {
            // The middle may lie too near to the zero to tell while points further off do.
            const T low((T(0.5) * (point(bracket.lower()) + middle)).mid());
            const T high((T(0.5) * (middle + point(bracket.upper()))).mid());
            if (value(low).upper() < 0) next = clamped(next, T(low.lower(), bracket.upper()));
            if (value(high).lower() > 0) next = clamped(next, T(bracket.lower(), high.upper()));
            if (!(width(next) <= width(bracket) * 0.875)) return next;
        }
        bracket = next;
    }
    return bracket;
}

}  // namespace vcell
