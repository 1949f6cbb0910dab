/// Functions g(x, y) whose zeros are a curve, behind one interface for both interval rungs of the ladder, and
/// the search for the zero of a function of one variable that all refinement comes down to.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <utility>

#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/jet.hpp"
#include "../../core/numbers/wide_interval.hpp"

namespace vcell {

/// Below this share of the scale of the coordinates a coincidence is assumed.
inline constexpr double assumed_width = 0x1p-200;

/// A value with first, and with first and second derivatives in x and y.
template <class T>
using Jet1 = Jet<T, 2>;
template <class T>
using Jet2 = Jet<Jet<T, 2>, 2>;

/// g over a box: enclosures of its values, of its gradient, of its second derivatives. Where g is not defined
/// or not smooth all over the box, the enclosures are unbounded.
class DefiningFunction {
public:
    virtual ~DefiningFunction() = default;
    virtual Interval value(const Interval& x, const Interval& y) const = 0;
    virtual Wide value(const Wide& x, const Wide& y) const = 0;
    virtual Jet1<Interval> jet(const Interval& x, const Interval& y) const = 0;
    virtual Jet1<Wide> jet(const Wide& x, const Wide& y) const = 0;
    virtual Jet2<Interval> second_jet(const Interval& x, const Interval& y) const = 0;
    virtual Jet2<Wide> second_jet(const Wide& x, const Wide& y) const = 0;
};

namespace detail {

template <class G>
class CallableFunction final : public DefiningFunction {
public:
    explicit CallableFunction(G g) : g_(std::move(g)) {}
    Interval value(const Interval& x, const Interval& y) const override { return g_(x, y); }
    Wide value(const Wide& x, const Wide& y) const override { return g_(x, y); }
    Jet1<Interval> jet(const Interval& x, const Interval& y) const override { return first(x, y); }
    Jet1<Wide> jet(const Wide& x, const Wide& y) const override { return first(x, y); }
    Jet2<Interval> second_jet(const Interval& x, const Interval& y) const override { return second(x, y); }
    Jet2<Wide> second_jet(const Wide& x, const Wide& y) const override { return second(x, y); }

private:
    template <class T>
    Jet1<T> first(const T& x, const T& y) const {
        return g_(Jet1<T>::variable(x, 0), Jet1<T>::variable(y, 1));
    }
    template <class T>
    Jet2<T> second(const T& x, const T& y) const {
        return g_(Jet2<T>::variable(Jet1<T>::variable(x, 0), 0),
                  Jet2<T>::variable(Jet1<T>::variable(y, 1), 1));
    }
    G g_;
};

}  // namespace detail

/// The defining function of a callable `T g(const T& x, const T& y)` generic in the number type.
template <class G>
std::shared_ptr<const DefiningFunction> defining_function(G g) {
    return std::make_shared<detail::CallableFunction<G>>(std::move(g));
}

/// An enclosure of an exact number on either rung.
template <class T>
T enclosure_of(const Exact& e) {
    if constexpr (std::is_same_v<T, Interval>) {
        return e.enclosure();
    } else {
        // Doubles peeled off from the front until they fill the number type.
        T sum(0.0);
        Exact rest = e;
        for (int bits = 0; bits <= T::bits && rest.sign() != Sign::Zero; bits += 53) {
            const double head = rest.enclosure().lower();
            sum += T(head);
            rest -= Exact(head);
        }
        return sum + T(rest.enclosure());
    }
}

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
