/// What heights around a cylinder are made of: linear functions of the unit normal, and quadratic ones of the
/// place along the axis, in Interval or Wide.
///
/// As Intervals, vectors and places are kept as doubles and the radii of balls about them. A value is then
/// computed in doubles and moved outwards once, by a bound on all that the balls and rounding may do to it:
/// with u = 2^-53, each operation errs by u of its result [Higham02, sec. 3.3], and what underflows by
/// 2^-1075 a product. Bounds are sums of numbers >= 0 that err by a few u of themselves, and are taken that
/// much larger. Where numbers overflow nothing is bounded: the whole line.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/sign.hpp"
#include "root_range.hpp"

namespace vcell {

/// Sine and cosine of the angle at x of the half-angle coordinate: 2 atan x, from x = 1 on half a turn and 2
/// atan (x - 2).
template <class T>
struct TurnedEnd {
    T sine, cosine;

    TurnedEnd() = default;
    explicit TurnedEnd(const T& x) {
        const bool is_back = x.upper() > 1;
        const T one(1.0), two(2.0), t = is_back ? x - two : x, m = two / (one + square(t)), X = t * m,
                                    Z = m - one;
        sine = is_back ? -X : X;
        cosine = is_back ? -Z : Z;
    }
};

/// A number in a product.
template <class T>
struct NumberBall {
    T value;

    NumberBall() = default;
    explicit NumberBall(const T& v) : value(v) {}
};

/// v.u = v_x sin phi + v_z cos phi of a vector v, whose y does not count.
template <class T>
class LinearOfNormals {
public:
    LinearOfNormals() = default;
    explicit LinearOfNormals(const std::array<T, 3>& v) : x_(v[0]), z_(v[2]) {}

    /// v.u and its derivative by phi.
    std::array<T, 2> at(const TurnedEnd<T>& e) const {
        return {x_ * e.sine + z_ * e.cosine, x_ * e.cosine - z_ * e.sine};
    }
    /// |v|, the most that v.u is, or what reaches from below it to above.
    T size() const { return sqrt(square(x_) + square(z_)); }
    /// v + s y a.
    LinearOfNormals plus(const NumberBall<T>& s, const T& y, const LinearOfNormals& a) const {
        const T t = s.value * y;
        LinearOfNormals out;
        out.x_ = x_ + t * a.x_;
        out.z_ = z_ + t * a.z_;
        return out;
    }

private:
    T x_, z_;
};

/// c0 + c1 y + c2 y^2.
template <class T>
class QuadraticOf {
public:
    struct Range {
        T value, slope;
    };

    QuadraticOf() = default;
    explicit QuadraticOf(const std::array<T, 3>& c) : c_(c) {}

    /// Pre: c2 has one sign.
    Range over(const T& y) const {
        const auto at = [&](const T& p) { return c_[0] + p * (c_[1] + c_[2] * p); };
        Range r{hull(at(bottom(y)), at(top(y))), c_[1] + T(2.0) * c_[2] * y};
        if (!r.slope.sign() && c_[2].sign() && *c_[2].sign() != Sign::Zero)
            r.value = hull(r.value, c_[0] - square(c_[1]) / (T(4.0) * c_[2]));
        return r;
    }

private:
    std::array<T, 3> c_;
};

namespace linear_ball_detail {

using roundoff::u;
constexpr double tiniest = std::numeric_limits<double>::denorm_min();
// Sums of less than 16 numbers >= 0, each made of less than 8 of them by products, are taken so much larger.
constexpr double larger = 1 + 32 * u;

constexpr double largest = 0x1p+900;
// Pre: the bound contains u of all that the value is the sum of, and u of the value for the move itself. So
// where it is bounded nothing has overflowed.
inline Interval ball(double value, double error) {
    return error < largest ? Interval(value - error, value + error) : Interval::whole();
}
inline Interval hull_of_balls(DoublePair values, DoublePair errors) {
    if (!(errors.first() < largest && errors.second() < largest)) return Interval::whole();
    const DoublePair low = values + -errors, high = values + errors;
    return {std::min(low.first(), low.second()), std::max(high.first(), high.second())};
}

}  // namespace linear_ball_detail

template <>
struct NumberBall<Interval> {
    double middle = 0, radius = 0;

    NumberBall() = default;
    explicit NumberBall(const Interval& v) : middle(v.mid()), radius(v.radius()) {}
};

// 1 + t^2 errs by 2 u of itself, m by 3 u, the sine t m by 4 u: next to 0 it is as well known as elsewhere.
// The cosine m - 1 errs by what m does, and u of itself.
template <>
struct TurnedEnd<Interval> {
    double sine = 0, cosine = 1, sine_error = 0, cosine_error = 0;

    TurnedEnd() = default;
    /// Pre: x is a number. From 1 on 2 is subtracted exactly.
    explicit TurnedEnd(const Interval& x) {
        using linear_ball_detail::u;
        const bool is_back = x.upper() > 1;
        const double t = is_back ? x.lower() - 2 : x.lower(), m = 2 / (1 + t * t), X = t * m, Z = m - 1;
        sine = is_back ? -X : X;
        cosine = is_back ? -Z : Z;
        sine_error = 4 * u * std::abs(X) + linear_ball_detail::tiniest;
        cosine_error = 3 * u * m + u * std::abs(Z);
    }
};

template <>
class LinearOfNormals<Interval> {
public:
    LinearOfNormals() = default;
    explicit LinearOfNormals(const std::array<Interval, 3>& v)
        : x_(v[0].mid()), z_(v[2].mid()), x_radius_(v[0].radius()), z_radius_(v[2].radius()) {}

    // Of v_x s, |v_x - x| |s| + |x| |s - sine|; of computing the sum of two products u of each of these and u
    // of the sum, of moving that outwards one more. Side by side, as both take the same steps.
    std::array<Interval, 2> at(const TurnedEnd<Interval>& e) const {
        using namespace linear_ball_detail;
        const auto both = &DoublePair::both;
        const DoublePair turned(e.sine, e.cosine), errors(e.sine_error, e.cosine_error), sizes = abs(turned);
        const DoublePair p = both(x_) * turned, q = both(z_) * DoublePair(e.cosine, -e.sine), value = p + q;
        const DoublePair error = both(x_radius_) * sizes + both(z_radius_) * sizes.swapped() +
                                 both(std::abs(x_) + x_radius_) * errors +
                                 both(std::abs(z_) + z_radius_) * errors.swapped();
        const DoublePair bound =
            (error + both(u) * (abs(p) + abs(q) + both(2) * abs(value))) * both(larger) + both(4 * tiniest);
        const DoublePair low = value + -bound, high = value + bound;
        if (!(bound.first() < largest && bound.second() < largest))
            return {ball(value.first(), bound.first()), ball(value.second(), bound.second())};
        return {Interval(low.first(), high.first()), Interval(low.second(), high.second())};
    }
    /// About v.u and its derivative by phi.
    std::array<double, 2> near(double sine, double cosine) const {
        return {x_ * sine + z_ * cosine, x_ * cosine - z_ * sine};
    }
    Interval size() const {
        using namespace linear_ball_detail;
        const double norm2 = x_ * x_ + z_ * z_, radius = x_radius_ + z_radius_,
                     magnitude = std::abs(x_) + std::abs(z_);
        if (!(radius < largest)) return Interval::whole();
        if (!root_range_detail::is_usual(norm2)) return {0.0, (radius + magnitude) * larger + tiniest};
        return ball(std::sqrt(norm2), (radius + 8 * u * magnitude) * larger + tiniest);
    }
    // Each part of s y a errs by |y| (|s| r_a + r_s (|a| + r_a)), of computing t = s y and its product by u
    // |t| |a| each, the sum by u of itself. What underflows in t is multiplied by a, in the bound by y.
    LinearOfNormals plus(const NumberBall<Interval>& s, const Interval& y, const LinearOfNormals& a) const {
        using namespace linear_ball_detail;
        const double at = y.lower(), t = s.middle * at, size = std::abs(at), slope = std::abs(s.middle),
                     turn = std::abs(t);
        const auto add = [&](double b, double b_radius, double p, double p_radius, double& sum,
                             double& radius) {
            const double most = std::abs(p);
            sum = b + t * p;
            radius = (b_radius + size * (slope * p_radius + s.radius * (most + p_radius)) +
                      u * (2 * turn * most + std::abs(sum))) *
                         larger +
                     4 * tiniest * (1 + size + most);
        };
        LinearOfNormals out;
        add(x_, x_radius_, a.x_, a.x_radius_, out.x_, out.x_radius_);
        add(z_, z_radius_, a.z_, a.z_radius_, out.z_, out.z_radius_);
        return out;
    }

private:
    // v is within these radii of (x, z).
    double x_ = 0, z_ = 0, x_radius_ = 0, z_radius_ = 0;
};

template <>
class QuadraticOf<Interval> {
public:
    struct Range {
        Interval value, slope;
    };

    QuadraticOf() = default;
    explicit QuadraticOf(const std::array<Interval, 3>& c) {
        for (int i = 0; i < 3; ++i) {
            middle_[i] = c[i].mid();
            radius_[i] = c[i].radius();
        }
        is_curved_ = c[2].sign() && *c[2].sign() != Sign::Zero;
        if (is_curved_) turn_ = c[0] - square(c[1]) / (Interval(4.0) * c[2]);
    }

    // By Horner's rule c1 + c2 y errs by u (|c2 y| + |c1 + c2 y|), the value by |y| times that, u of its own
    // product and u of itself; moving it outwards takes one more [Higham02, sec. 5.1]. Of the slope likewise.
    // Both ends side by side.
    Range over(const Interval& y) const {
        using namespace linear_ball_detail;
        const auto both = &DoublePair::both;
        const DoublePair at(y.lower(), y.upper()), size = abs(at);
        const DoublePair square = both(middle_[2]) * at, inner = both(middle_[1]) + square,
                         product = at * inner, sum = both(middle_[0]) + product;
        const DoublePair inner_error =
            both(radius_[1]) + size * both(radius_[2]) + both(u) * (abs(square) + abs(inner));
        const DoublePair error =
            both(radius_[0]) + size * inner_error + both(u) * (abs(product) + both(2) * abs(sum));
        const DoublePair twice = both(2 * middle_[2]) * at, slope = both(middle_[1]) + twice;
        const DoublePair slope_error = both(radius_[1]) + both(2) * size * both(radius_[2]) +
                                       both(u) * (abs(twice) + both(2) * abs(slope));
        Range r{hull_of_balls(sum, error * both(larger) + both(4 * tiniest) * (both(1) + size)),
                hull_of_balls(slope, slope_error * both(larger) + both(4 * tiniest))};
        if (is_curved_ && !r.slope.sign() && y.lower() != y.upper()) r.value = hull(r.value, turn_);
        return r;
    }

    /// About the value and the slope.
    std::array<double, 2> near(double y) const {
        return {middle_[0] + y * (middle_[1] + y * middle_[2]), middle_[1] + 2 * y * middle_[2]};
    }

private:
    std::array<double, 3> middle_{}, radius_{};
    Interval turn_;  // the least or greatest value, if c2 has a sign
    bool is_curved_ = false;
};

}  // namespace vcell
