/// Unit normals of curved bases over boxes of the chart, with their derivatives, in Interval or Wide.
///
/// With m = 2 / W
///
///     u = (X, Y, m - 1),   X = x m,  Y = y m,       u_x = (m - X^2, -XY, -X m),  u_y = (-XY, m - Y^2, -Y m)
///
/// in the stereographic chart, and without Y in half angles: everything is a polynomial in the three bounded
/// numbers X, Y, m.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "../../core/numbers/sign.hpp"
#include "../../core/numbers/wide.hpp"
#include "form_family.hpp"
#include "function_jet.hpp"
#include "linear_ball.hpp"
#include "radial_form.hpp"

namespace vcell {

/// Linear functions of the unit normals around a cylinder, v.u = v_x sin phi + v_z cos phi, over a stretch of
/// the half-angle coordinate x: with phi' = m,
///
///     (v.u)' = m g,   (v.u)'' = -m (m v.u + X g),   g = v_x cos phi - v_z sin phi,
///
/// X = x m counted from the middle of each half. v.u and g are monotone but where the other vanishes, which
/// on a stretch of at most half a turn is once at most: their ranges are those of their ends and of +-|v|.
/// Over x = 1 the second derivative is the hull of both sides' (first ones are continuous there).
template <class T>
class NormalsAround {
public:
    NormalsAround() = default;
    explicit NormalsAround(const T& x)
        : is_point_(x.lower() == x.upper()), is_wide_(x.upper() - 2 > x.lower()) {
        ends_[0] = TurnedEnd<T>(bottom(x));
        ends_[1] = is_point_ ? ends_[0] : TurnedEnd<T>(top(x));
        const T one(1.0), two(2.0);
        const auto half = [&](const T& t) {
            const T m = two / (one + square(t));
            return std::array<T, 2>{m, t * m};
        };
        const auto [m, X] = half(x.lower() >= 1 ? x - two : T(x.lower(), std::min(x.upper(), one.upper())));
        m_ = m;
        X_ = X;
        if (x.lower() >= 1 || x.upper() <= 1) return;
        const auto [back_m, back_X] = half(T(one.lower(), x.upper()) - two);
        m_ = hull(m, back_m);
        X_ = hull(X, back_X);
    }

    template <int order>
    FunctionJet<T> along(const LinearOfNormals<T>& v) const {
        const auto [at_first, at_last] = at_ends(v);
        FunctionJet<T> j;
        j.v = range(at_first[0], at_last[0], at_first[1], at_last[1], v);
        if constexpr (order > 0) {
            const T g = range(at_first[1], at_last[1], -at_first[0], -at_last[0], v);
            j.x = m_ * g;
            j.y = T(0.0);
            if constexpr (order > 1) {
                j.xx = -(m_ * (m_ * j.v + X_ * g));
                j.xy = j.yy = T(0.0);
            }
        }
        return j;
    }

private:
    // v.u and g at both ends.
    std::array<std::array<T, 2>, 2> at_ends(const LinearOfNormals<T>& v) const {
        const std::array<T, 2> first = v.at(ends_[0]);
        return {first, is_point_ ? first : v.at(ends_[1])};
    }
    // From both ends' values and derivatives by phi.
    T range(const T& first, const T& last, const T& slope_first, const T& slope_last,
            const LinearOfNormals<T>& v) const {
        if (is_point_) return first;
        const T ends = hull(first, last);
        const bool rises = slope_first.sign() == Sign::Positive, falls = slope_first.sign() == Sign::Negative,
                   has_risen = slope_last.sign() == Sign::Positive,
                   has_fallen = slope_last.sign() == Sign::Negative;
        if (!is_wide_ && ((rises && has_risen) || (falls && has_fallen))) return ends;
        // The slope at one end tells what extremum there may be where that at the other has no known sign;
        // where neither has, both ends are next to extrema.
        const T size = v.size();
        if (!is_wide_ && (rises || has_fallen || (!falls && !has_risen && ends.lower() > 0)))
            return hull(ends, size);
        if (!is_wide_ && (falls || has_risen || ends.upper() < 0)) return hull(ends, -size);
        return hull(hull(ends, size), -size);
    }

    std::array<TurnedEnd<T>, 2> ends_;
    T m_, X_;
    bool is_point_ = true;
    bool is_wide_ = false;  // more than half a turn; 2 is subtracted exactly from what is 1 at least
};

/// The unit normals of a sphere over a box of the stereographic chart, with their derivatives.
template <class T>
class NormalsOfSphere {
public:
    using Jets = std::array<FunctionJet<T>, 3>;

    NormalsOfSphere() = default;
    NormalsOfSphere(const T& x, const T& y)
        : u_(normals(x, y)), is_point_(x.lower() == x.upper() && y.lower() == y.upper()) {
        if (is_point_) return;
        const T mx = x.mid(), my = y.mid();
        middle_ = normals(mx, my);
        dx_ = x - mx;
        dy_ = y - my;
        // Mean value forms, and what follows from the sharper numbers.
        const std::array<T, 3> sharp{refined(u_[0], middle_[0]).v, refined(u_[1], middle_[1]).v,
                                     refined(u_[2], middle_[2]).v};
        u_ = jets(sharp[0], sharp[1], sharp[2] + T(1.0));
    }

    /// The jet of v.u.
    template <int order>
    FunctionJet<T> along(const std::array<T, 3>& v) const {
        if (is_point_) return sum<order>(v, u_);
        return refined(sum<2>(v, u_), sum<1>(v, middle_));
    }

private:
    static Jets normals(const T& x, const T& y) {
        const T m = T(2.0) / (T(1.0) + square(x) + square(y));
        return jets(x * m, y * m, m);
    }
    static Jets jets(const T& X, const T& Y, const T& m) {
        const T two(2.0), XX = square(X), YY = square(Y), XY = X * Y, three_m = T(3.0) * m;
        const T p = two * XX - m, q = two * YY - m;
        return {{{X, m - XX, -XY, X * (two * XX - three_m), Y * p, X * q},
                 {Y, -XY, m - YY, Y * p, X * q, Y * (two * YY - three_m)},
                 {m - T(1.0), -(X * m), -(Y * m), m * p, two * XY * m, m * q}}};
    }

    // With mean value forms for the value and the first derivatives.
    FunctionJet<T> refined(FunctionJet<T> j, const FunctionJet<T>& middle) const {
        j.x = intersection(j.x, middle.x + j.xx * dx_ + j.xy * dy_);
        j.y = intersection(j.y, middle.y + j.xy * dx_ + j.yy * dy_);
        j.v = intersection(j.v, middle.v + j.x * dx_ + j.y * dy_);
        return j;
    }
    static T intersection(const T& a, const T& b) {
        return {std::max(a.lower(), b.lower()), std::min(a.upper(), b.upper())};
    }

    template <int order>
    static FunctionJet<T> sum(const std::array<T, 3>& v, const Jets& u) {
        const auto dot = [&](T FunctionJet<T>::*part) {
            return v[0] * (u[0].*part) + v[2] * (u[2].*part) + v[1] * (u[1].*part);
        };
        FunctionJet<T> j;
        j.v = dot(&FunctionJet<T>::v);
        if constexpr (order > 0) {
            j.x = dot(&FunctionJet<T>::x);
            j.y = dot(&FunctionJet<T>::y);
        }
        if constexpr (order > 1) {
            j.xx = dot(&FunctionJet<T>::xx);
            j.xy = dot(&FunctionJet<T>::xy);
            j.yy = dot(&FunctionJet<T>::yy);
        }
        return j;
    }

    Jets u_, middle_;
    T dx_, dy_;  // the box less its middle
    bool is_point_ = true;
};

/// A function of y along a cylinder's axis, with its derivatives.
template <class T>
struct AlongAxis {
    T v, y, yy;

    friend AlongAxis operator*(const AlongAxis& a, const AlongAxis& b) {
        return {a.v * b.v, a.v * b.y + a.y * b.v, a.v * b.yy + T(2.0) * a.y * b.y + a.yy * b.v};
    }
};

/// From a tip at the named end, towards the region.
template <class T>
AlongAxis<T> distance_from_tip(AxialEnd end, double tip, const T& y) {
    return end == AxialEnd::Low ? AlongAxis<T>{y - T(tip), T(1.0), T(0.0)}
                                : AlongAxis<T>{T(tip) - y, T(-1.0), T(0.0)};
}

/// The unit normals over a box of the chart, and how far the box is from tips.
template <class T>
class RadialNormals {
public:
    RadialNormals() = default;
    RadialNormals(Chart chart, const T& x, const T& y, const AxialTips& tips = {})
        : y_(y), middle_y_(y.mid()) {
        for (const AxialEnd end : {AxialEnd::Low, AxialEnd::High}) {
            if (!tips[end]) continue;
            const AlongAxis<T> distance = distance_from_tip(end, *tips[end], y);
            distances_ = distances_ ? *distances_ * distance : distance;
        }
        if (chart.is_cylinder())
            normals_ = NormalsAround<T>(x);
        else
            normals_ = NormalsOfSphere<T>(x, y);
    }

    const T& y() const { return y_; }
    /// A number in y.
    const T& middle_y() const { return middle_y_; }
    /// The product of the distances from all tips. Pre: there is one.
    const AlongAxis<T>& distances() const { return *distances_; }

    /// The jet of v.u; over a half-angle chart without v_y.
    template <int order>
    FunctionJet<T> along(const std::array<T, 3>& v) const {
        if (around()) return around()->template along<order>(LinearOfNormals<T>(v));
        return std::get_if<NormalsOfSphere<T>>(&normals_)->template along<order>(v);
    }
    /// Null over a sphere.
    const NormalsAround<T>* around() const { return std::get_if<NormalsAround<T>>(&normals_); }

private:
    std::variant<NormalsAround<T>, NormalsOfSphere<T>> normals_;
    T y_, middle_y_;
    std::optional<AlongAxis<T>> distances_;
};

// heights.cpp compiles them, once.
extern template class NormalsOfSphere<Interval>;
extern template class NormalsOfSphere<Wide>;
extern template class RadialNormals<Interval>;
extern template class RadialNormals<Wide>;

}  // namespace vcell
