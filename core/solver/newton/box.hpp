/// Boxes: products of intervals, in double or in multiprecision.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <optional>

#include "../../numbers/interval.hpp"
#include "../../numbers/wide.hpp"

namespace vcell {

/// x_0 in b[0], ..., x_{N-1} in b[N-1]; closed. A plain array, so that a callable generic in the number
/// type takes it as it takes a point.
template <int N>
using IntervalBox = std::array<Interval, N>;
template <int N>
using WideBox = std::array<Wide, N>;
template <int N>
using Point = std::array<double, N>;

/// The members that both share; nothing when there are none.
inline std::optional<Interval> intersection(const Interval& a, const Interval& b) {
    const double lo = std::max(a.lower(), b.lower()), hi = std::min(a.upper(), b.upper());
    if (lo <= hi) return Interval(lo, hi);
    return std::nullopt;
}
inline std::optional<Wide> intersection(const Wide& a, const Wide& b) {
    const Wide::Float &lo = std::max(a.lower(), b.lower()), &hi = std::min(a.upper(), b.upper());
    if (lo <= hi) return Wide(lo, hi);
    return std::nullopt;
}
template <class T, std::size_t N>
std::optional<std::array<T, N>> intersection(const std::array<T, N>& a, const std::array<T, N>& b) {
    std::array<T, N> result;
    for (std::size_t i = 0; i < N; ++i) {
        const std::optional<T> shared = intersection(a[i], b[i]);
        if (!shared) return std::nullopt;
        result[i] = *shared;
    }
    return result;
}

/// Have they a point in common? Touching counts.
template <class T, std::size_t N>
bool overlap(const std::array<T, N>& a, const std::array<T, N>& b) {
    for (std::size_t i = 0; i < N; ++i)
        if (!(a[i].lower() <= b[i].upper() && b[i].lower() <= a[i].upper())) return false;
    return true;
}

template <class T>
bool is_subset(const T& inner, const T& outer) {
    return outer.lower() <= inner.lower() && inner.upper() <= outer.upper();
}
template <class T, std::size_t N>
bool is_subset(const std::array<T, N>& inner, const std::array<T, N>& outer) {
    for (std::size_t i = 0; i < N; ++i)
        if (!is_subset(inner[i], outer[i])) return false;
    return true;
}
template <std::size_t N>
bool contains(const std::array<Interval, N>& box, const std::array<double, N>& p) {
    for (std::size_t i = 0; i < N; ++i)
        if (!box[i].contains(p[i])) return false;
    return true;
}

template <class T, std::size_t N>
std::array<T, N> hull(const std::array<T, N>& a, const std::array<T, N>& b) {
    std::array<T, N> result;
    for (std::size_t i = 0; i < N; ++i) result[i] = hull(a[i], b[i]);
    return result;
}

/// Upper bound of the largest side.
template <std::size_t N>
double width(const std::array<Interval, N>& box) {
    double w = 0;
    for (const Interval& side : box) w = std::max(w, side.width());
    return w;
}

template <std::size_t N>
std::array<double, N> mid(const std::array<Interval, N>& box) {
    std::array<double, N> m;
    for (std::size_t i = 0; i < N; ++i) m[i] = box[i].mid();
    return m;
}

/// The same box or point in another number type; outward where it is a narrower one.
template <class T, class S, std::size_t N>
std::array<T, N> converted(const std::array<S, N>& box) {
    std::array<T, N> result;
    for (std::size_t i = 0; i < N; ++i) {
        if constexpr (std::same_as<S, Wide> && std::same_as<T, Interval>)
            result[i] = box[i].enclosure();
        else
            result[i] = T(box[i]);
    }
    return result;
}

}  // namespace vcell
