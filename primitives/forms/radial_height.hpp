/// Heights over curved bases and their derivatives over boxes of the chart, in Interval or Wide.
///
/// What is enclosed is -q = -Q / W, the negative reciprocal of the distance from the centre or axis
/// (primitives/forms/radial_form.hpp): forms are compared by -Q, which is polynomial for most, but the common
/// factor W grows over the chart and would blur differences; q belongs to the base point alone. With m = 2 /
/// W
///
///     u = (X, Y, m - 1),   X = x m,  Y = y m,       u_x = (m - X^2, -XY, -X m),  u_y = (-XY, m - Y^2, -Y m)
///
/// in the stereographic chart, and without Y in half angles: everything is a polynomial in the three bounded
/// numbers X, Y, m.
///
/// Over a cylinder -q is multiplied by the distances along the axis to the family's tips, where heights grow
/// without bound. That of a plane or a side of the box through a tip is then constant along the axis but for
/// rounding: with C linear in y and C(e) at the tip e,
///
///     d/dy (e - y) / C = -C(e) / C^2
///
/// Around a cylinder the doubles of an Interval would be rounded outwards some hundred times for a height.
/// What is linear in the normal and what is quadratic along the axis is there computed in doubles with one
/// bound on its error (linear_ball.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <variant>

#include "../../core/numbers/sign.hpp"
#include "../../core/numbers/wide.hpp"
#include "form_family.hpp"
#include "function_jet.hpp"
#include "linear_ball.hpp"
#include "radial_form.hpp"
#include "root_range.hpp"

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

/// The coefficients of a form in one number type.
template <class T>
class RadialHeight {
public:
    /// `convert` takes an Exact to T.
    template <class Convert>
    RadialHeight(const RadialForm& form, Convert&& convert, const AxialTips& tips = {})
        : has_root_(form.has_root()),
          is_hollow_(form.is_hollow),
          tips_(tips),
          b0_(convert(form.b0)),
          slope_(convert(form.slope)),
          a0_(convert(form.a0)) {
        if (const auto own = form.falls_to()) {
            if (const std::optional<double>& y = tips_[*own]) {
                own_tip_ = own;
                c_at_tip_ = convert(form.c[0] + *y * form.c[1]);
            }
        }
        for (int i = 0; i < 3; ++i) {
            c_[i] = convert(form.c[i]);
            b_[i] = convert(form.b[i]);
            a_[i] = convert(form.a[i]);
        }
        around_b_ = LinearOfNormals<T>(b_);
        around_a_ = LinearOfNormals<T>(a_);
        axial_slope_ = NumberBall<T>(slope_);
        along_axis_ = QuadraticOf<T>(c_);
    }
    /// A circular form (k r^2 + a x + b y + e) / w over a sphere, w > 0: with r^2 = (1 - u_z) W / 2, x = u_x
    /// W / 2, ...
    RadialHeight(const T& k, const T& a, const T& b, const T& e, const T& w) : has_root_(false) {
        const T quarter(-0.25), zero(0.0);
        c_ = {w, zero, zero};
        b0_ = quarter * (k + e);
        b_ = {quarter * a, quarter * b, quarter * (e - k)};
        a_ = {zero, zero, zero};
        slope_ = zero;
    }

    /// Derivatives up to the given order; the others are unset. Pre: the normals know the same tips. Where
    /// the root may vanish (the object is met at infinity only) the first ones bound difference quotients,
    /// and second ones are the whole line.
    template <int order>
    FunctionJet<T> jet(const RadialNormals<T>& n) const {
        if (!tips_.any()) return plain_jet<order>(n);
        return own_tip_ ? jet_at_own_tip<order>(n) : times<order>(plain_jet<order>(n), n.distances());
    }

    /// Without the distances from tips.
    template <int order>
    FunctionJet<T> plain_jet(const RadialNormals<T>& n) const {
        // B = b.u + slope y a.u, the two parts the larger and the more opposite to each other the farther the
        // box is from y = 0: they are added up at the box's middle, where b + slope y a are numbers. C is
        // constant around a cylinder, and everywhere over a sphere.
        FunctionJet<T> B, f;
        T C = c_[0], C_y(0.0);
        const NormalsAround<T>* around = n.around();
        if (!around)
            B = n.template along<order>(b_);
        else if (has_root_)
            B = around->template along<order>(around_b_.plus(axial_slope_, n.middle_y(), around_a_));
        else
            B = around->template along<order>(around_b_);
        B.v += b0_;
        if (around) {
            const auto [value, slope] = along_axis_.over(n.y());
            C = value;
            C_y = slope;
            if (C.sign() != Sign::Positive) return unknown();
        }
        if (!has_root_) {
            f.v = -twice(B.v) / C;
            if constexpr (order > 0) {
                f.x = -twice(B.x) / C;
                f.y = around ? -(C_y * f.v) / C : -twice(B.y) / C;
            }
            if constexpr (order > 1) {
                f.xx = -twice(B.xx) / C;
                f.xy = around ? -(C_y * f.x) / C : -twice(B.xy) / C;
                f.yy = around ? -twice(c_[2] * f.v + C_y * f.y) / C : -twice(B.yy) / C;
            }
            return f;
        }
        FunctionJet<T> A = around ? around->template along<order>(around_a_) : n.template along<order>(a_);
        if (is_hollow_) {
            A.v += a0_;
            if (around) B.v += slope_ * (a0_ * n.middle_y());
        }
        if (around) {
            if constexpr (order > 0) B.y = slope_ * A.v;
            if constexpr (order > 1) B.xy = slope_ * A.x;
            if (n.y().lower() != n.y().upper()) {
                const T s = slope_ * (n.y() - n.middle_y());
                B.v += s * A.v;
                if constexpr (order > 0) B.x += s * A.x;
                if constexpr (order > 1) B.xx += s * A.xx;
            }
        }
        if (is_hollow_) return around ? hollow_jet<order>(B, A, C, &C_y) : hollow_jet<order>(B, A, C);
        // With s = B / R and k = A / R, R the root: q_B = (1 + s) / C, q_A = k, q_C = -q (1 + s) / (2 C). All
        // of q, s and k are monotone in each of B, A and C (in |A| for one sign of B): evaluated at the ends
        // nothing is lost.
        const T A2 = square(A.v);
        f.v = -root_range(B.v, A2, C);
        if constexpr (order > 0) {
            const T AC = A2 * C, B2 = square(B.v), root_C = sqrt(C), s = share(B.v, AC),
                    k = share(A.v * root_C, B2) / root_C;
            const T slope = (T(1.0) + s) / C, half_C_y = 0.5 * C_y, w = around ? B.y + half_C_y * f.v : B.y;
            // Over a cylinder A is constant along the axis.
            f.x = -(slope * B.x + k * A.x);
            f.y = around ? -(slope * w) : -(slope * B.y + k * A.y);
            if constexpr (order > 1) {
                const T R = sqrt(B2 + AC);
                if (R.sign() != Sign::Positive) {
                    f.xx = f.xy = f.yy = T::whole();
                    return f;
                }
                // C f^2 + 2 B f - A^2 = 0 differentiated twice, f_u = -((1 + s) B_u / C + k A_u) put in, and
                // 1 - s^2 = C k^2: where C is constant
                //
                //     R f_uv = B_uv f - A A_uv - D_u D_v,   D_u = k B_u - s A_u.
                //
                // Where it depends on y and A does not, w = B_y + C_y f / 2 takes the place of B_y in f_y and
                // D_y, and R f_xy gains C_y f f_x / 2, R f_yy, as B_yy is zero, C_yy f^2 / 2 + C_y f f_y.
                const T D_x = k * B.x - s * A.x, D_y = around ? k * w : k * B.y - s * A.y;
                f.xx = (B.xx * f.v - A.v * A.xx - square(D_x)) / R;
                if (around) {
                    f.xy = ((B.xy + half_C_y * f.x) * f.v - D_x * D_y) / R;
                    f.yy = (c_[2] * square(f.v) + C_y * (f.v * f.y) - square(D_y)) / R;
                } else {
                    f.xy = (B.xy * f.v - A.v * A.xy - D_x * D_y) / R;
                    f.yy = (B.yy * f.v - A.v * A.yy - square(D_y)) / R;
                }
            }
        }
        return f;
    }

    /// What is known of a plain height, or of a difference of such, times the distances from tips.
    FunctionJet<T> with_tips(const FunctionJet<T>& plain, const RadialNormals<T>& n) const {
        return tips_.any() ? times<2>(plain, n.distances()) : plain;
    }

    /// About the plain height and its derivatives where the angle's sine and cosine are these and x grows by
    /// 1 / m of it. Pre: T is Interval, over a cylinder.
    std::array<double, 3> near(double sine, double cosine, double m, double y) const {
        const auto [C, C_y] = along_axis_.near(y);
        auto [B, B_x] = around_b_.near(sine, cosine);
        B += b0_.mid();
        if (!has_root_) return {-2 * B / C, -2 * m * B_x / C, 2 * B * C_y / (C * C)};
        auto [A, A_x] = around_a_.near(sine, cosine);
        if (is_hollow_) A += a0_.mid();
        const double slope = axial_slope_.middle, B_y = slope * A;
        B += slope * y * A;
        B_x += slope * y * A_x;
        if (is_hollow_) {
            const double R = std::sqrt(std::max(0.0, B * B - A * A * C)), f = -(B + R) / C;
            return {f, m * (f * B_x + A * A_x) / R, f * (0.5 * C_y * f + B_y) / R};
        }
        const double R = std::sqrt(B * B + A * A * C), f = B < 0 ? -A * A / (R - B) : -(B + R) / C;
        return {f, m * (f * B_x - A * A_x) / R, f * (0.5 * C_y * f + B_y) / R};
    }

private:
    // C f^2 + 2 B f + A^2 = 0 over a sphere, where C is constant: with s = B / R and k = A / R, R^2 = B^2 -
    // A^2 C,
    //
    //     f_u = -(1 + s) B_u / C + k A_u,   R f_uv = B_uv f + A A_uv + D_u D_v,   D_u = k B_u - s A_u,
    //
    // as s^2 - 1 = C k^2. Around a cylinder, where C depends on y by C_y and A does not, w = B_y + C_y f / 2
    // takes the place of B_y as in plain_jet(), and what is added is the same. Where R may vanish nothing is
    // said but f itself.
    template <int order>
    [[gnu::noinline]] FunctionJet<T> hollow_jet(const FunctionJet<T>& B, const FunctionJet<T>& A, const T& C,
                                                const T* C_y = nullptr) const {
        const T A2 = square(A.v);
        FunctionJet<T> f;
        f.v = -hollow_root_range(B.v, A2, C);
        if constexpr (order > 0) {
            const T s = hollow_share(B.v, B.v, A2, C), k = hollow_share(A.v, B.v, A2, C);
            if (!is_bounded(s) || !is_bounded(k)) {
                f.x = f.y = f.xx = f.xy = f.yy = T::whole();
                return f;
            }
            const T slope = (T(1.0) + s) / C;
            f.x = k * A.x - slope * B.x;
            const T half_C_y = C_y != nullptr ? 0.5 * *C_y : T(0.0),
                    w = C_y != nullptr ? B.y + half_C_y * f.v : B.y;
            f.y = C_y != nullptr ? -(slope * w) : k * A.y - slope * B.y;
            if constexpr (order > 1) {
                const T R = hollow_root(B.v, A2, C), D_x = k * B.x - s * A.x;
                f.xx = (B.xx * f.v + A.v * A.xx + square(D_x)) / R;
                if (C_y != nullptr) {
                    const T D_y = k * w;
                    f.xy = ((B.xy + half_C_y * f.x) * f.v + D_x * D_y) / R;
                    f.yy = (c_[2] * square(f.v) + *C_y * (f.v * f.y) + square(D_y)) / R;
                    return f;
                }
                const T D_y = k * B.y - s * A.y;
                f.xy = (B.xy * f.v + A.v * A.xy + D_x * D_y) / R;
                f.yy = (B.yy * f.v + A.v * A.yy + square(D_y)) / R;
            }
        }
        return f;
    }
    static bool is_bounded(const T& t) {
        return t.lower() > T::whole().lower() && t.upper() < T::whole().upper();
    }
    // Pre: the root does not vanish.
    static T hollow_root(const T& B, const T& A2, const T& C) {
        return hull(sqrt(square(bottom(B)) - top(A2) * top(C)),
                    sqrt(square(top(B)) - bottom(A2) * bottom(C)));
    }

    static T twice(const T& t) { return t + t; }
    static FunctionJet<T> unknown() {
        return {T::whole(), T::whole(), T::whole(), T::whole(), T::whole(), T::whole()};
    }

    template <int order>
    static FunctionJet<T> times(const FunctionJet<T>& f, const AlongAxis<T>& d) {
        FunctionJet<T> out;
        out.v = f.v * d.v;
        if constexpr (order > 0) {
            out.x = f.x * d.v;
            out.y = f.y * d.v + f.v * d.y;
        }
        if constexpr (order > 1) {
            out.xx = f.xx * d.v;
            out.xy = f.xy * d.v + f.x * d.y;
            out.yy = f.yy * d.v + T(2.0) * f.y * d.y + f.v * d.yy;
        }
        return out;
    }
    // -2 B / C times the distances; B depends on x alone. From C at the tip C is told without cancellation,
    // and its quotient with the distance is monotone.
    template <int order>
    FunctionJet<T> jet_at_own_tip(const RadialNormals<T>& n) const {
        const T& y = n.y();
        const double tip = *tips_[*own_tip_];
        const auto C = [&](const T& at) { return c_at_tip_ + c_[1] * (at - T(tip)); };
        const auto ratio = [&](const T& at) { return distance_from_tip(*own_tip_, tip, at).v / C(at); };
        const T over = hull(C(bottom(y)), C(top(y)));
        if (over.sign() != Sign::Positive) return unknown();
        const T slope = (*own_tip_ == AxialEnd::Low ? c_at_tip_ : -c_at_tip_) / square(over), factor(-2.0);
        AlongAxis<T> k{factor * hull(ratio(bottom(y)), ratio(top(y))), factor * slope,
                       T(4.0) * c_[1] * slope / over};
        const AxialEnd other = *own_tip_ == AxialEnd::Low ? AxialEnd::High : AxialEnd::Low;
        if (tips_[other]) k = k * distance_from_tip(other, *tips_[other], y);
        FunctionJet<T> B = n.around()->template along<order>(around_b_);
        B.v += b0_;
        return times<order>(B, k);
    }

    bool has_root_;
    bool is_hollow_ = false;
    AxialTips tips_;
    std::optional<AxialEnd> own_tip_;  // the form's C is linear and falls towards it
    std::array<T, 3> c_, b_, a_;
    T b0_, slope_, a0_, c_at_tip_;
    // b, a, slope and c again, as they are evaluated around a cylinder.
    LinearOfNormals<T> around_b_, around_a_;
    NumberBall<T> axial_slope_;
    QuadraticOf<T> along_axis_;
};

// heights.cpp compiles them, once.
extern template class NormalsOfSphere<Interval>;
extern template class NormalsOfSphere<Wide>;
extern template class RadialNormals<Interval>;
extern template class RadialNormals<Wide>;

}  // namespace vcell
