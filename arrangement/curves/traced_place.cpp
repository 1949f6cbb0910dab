#include "traced_place.hpp"

namespace vcell {

using detail::signed_by;
using detail::solve_across;
using detail::turning;

TracedPlace::TracedPlace(std::shared_ptr<const DefiningFunction> g, int axis, double at, Interval other)
    : g_(std::move(g)), axis_(axis), at_(at), other_(other) {
    const auto d = (axis == 0 ? g_->jet(at, other) : g_->jet(other, at)).gradient;
    slope_ = d[1 - axis].sign().value();
    rough_ = compute<Interval>();
}

TracedPlace::TracedPlace(std::shared_ptr<const DefiningFunction> g, Interval box_x, Wide box_y, Sign beyond)
    : g_(std::move(g)), other_(box_x), box_y_(std::move(box_y)), beyond_(beyond) {
    const Interval rough_y = box_y_.enclosure();
    slope_ = g_->jet(box_x, rough_y).gradient[0].sign().value();
    if (Wide(rough_y).lower() == box_y_.lower() && Wide(rough_y).upper() == box_y_.upper()) {
        rough_ = compute<Interval>();
    } else {
        // Rounded outwards the box may hold other turns.
        fine_ = compute<Wide>();
        rough_ = {fine_->first.enclosure(), fine_->second.enclosure()};
    }
}

template <class T>
std::pair<T, T> TracedPlace::compute() const {
    if (axis_) {
        const T other = solve_across(*g_, *axis_, T(at_), other_, slope_);
        return *axis_ == 0 ? std::pair(T(at_), other) : std::pair(other, T(at_));
    }
    const auto x_at = [&](const T& y) { return solve_across(*g_, 1, y, other_, slope_); };
    T bracket;
    if constexpr (std::is_same_v<T, Interval>) {
        bracket = box_y_.enclosure();
    } else {
        bracket = box_y_;
    }
    if (beyond_ == Sign::Zero) return {x_at(bracket), bracket};
    const T y = enclose_zero(
        bracket, [&](const T& m) { return signed_by(beyond_, g_->jet(x_at(m), m).gradient[1]); },
        [&](const T& m) { return signed_by(beyond_, turning(g_->second_jet(x_at(m), m))); });
    return {x_at(y), y};
}

template <class T>
std::pair<T, T> TracedPlace::enclosure() const {
    if constexpr (std::is_same_v<T, Interval>) {
        return rough_;
    } else {
        if (!fine_) fine_ = compute<T>();
        return *fine_;
    }
}

template <class T>
T TracedPlace::coordinate(int axis) const {
    if (axis == axis_) return T(at_);
    return axis == 0 ? enclosure<T>().first : enclosure<T>().second;
}

template std::pair<Interval, Interval> TracedPlace::enclosure() const;
template std::pair<Wide, Wide> TracedPlace::enclosure() const;
template Interval TracedPlace::coordinate(int) const;
template Wide TracedPlace::coordinate(int) const;

}  // namespace vcell
