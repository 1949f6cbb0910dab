/// Places on traced curves {g = 0}, and the equations in one unknown that they solve.
#pragma once

#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "defining_function.hpp"

namespace vcell {

/// A place on a traced curve {g = 0}: where it meets x = const or y = const, or where it turns back in x.
/// Refined once, when asked for.
class TracedPlace {
public:
    /// Where the curve meets x = at (axis 0) or y = at (axis 1). Pre: within the range of the other
    /// coordinate the derivative of g by it has no zero, and g has one.
    TracedPlace(std::shared_ptr<const DefiningFunction> g, int axis, double at, Interval other);
    /// A turn within box_x * box_y. Pre: there g_x has no zero, and g_y changes its sign once along the
    /// curve, on the way up to `beyond`.
    TracedPlace(std::shared_ptr<const DefiningFunction> g, Interval box_x, Wide box_y, Sign beyond);

    template <class T>
    std::pair<T, T> enclosure() const;
    /// x (axis 0) or y (axis 1) alone.
    template <class T>
    T coordinate(int axis) const;

private:
    template <class T>
    std::pair<T, T> compute() const;

    std::shared_ptr<const DefiningFunction> g_;
    std::optional<int> axis_;  // none: a turn
    double at_ = 0;
    Interval other_;  // box_x of a turn
    Wide box_y_;
    Sign slope_ = Sign::Zero, beyond_ = Sign::Zero;  // slope_: of g by the other coordinate
    std::pair<Interval, Interval> rough_;
    mutable std::optional<std::pair<Wide, Wide>> fine_;
};

namespace detail {

template <class T>
T signed_by(Sign s, const T& t) {
    return s == Sign::Negative ? -t : t;
}

/// The other coordinate of the place where the curve meets the line on which the coordinate of `axis` is
/// `at`. Pre: over its range the derivative of g by it has the sign `slope`.
template <class T>
T solve_across(const DefiningFunction& g, int axis, const T& at, const Interval& range, Sign slope) {
    T start(range);
    // The lower rung's answer is the start of the higher one's.
    if constexpr (!std::is_same_v<T, Interval>)
        start = T(solve_across(g, axis, at.enclosure(), range, slope));
    return enclose_zero(
        start, [&](const T& u) { return signed_by(slope, axis == 0 ? g.value(at, u) : g.value(u, at)); },
        [&](const T& u) {
            return signed_by(slope, (axis == 0 ? g.jet(at, u) : g.jet(u, at)).gradient[1 - axis]);
        });
}

/// (d/dy) g_y(h(y), y) along the curve x = h(y): h' = -g_y / g_x.
template <class T>
T turning(const Jet2<T>& j) {
    const T g_x = j.gradient[0].value, g_y = j.gradient[1].value;
    return j.gradient[1].gradient[1] - j.gradient[1].gradient[0] * g_y / g_x;
}

}  // namespace detail

}  // namespace vcell
