/// Heights over curved bases and their derivatives over boxes of the chart, in Interval or Wide.
///
/// What is enclosed is -q = -Q / W, the negative reciprocal of the distance from the centre or axis
/// (primitives/forms/radial_form.hpp): forms are compared by -Q, which is polynomial for most, but the common
/// factor W grows over the chart and would blur differences; q belongs to the base point alone.
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
#include <optional>

#include "radial_form.hpp"
#include "radial_normals.hpp"
#include "root_by_tips.hpp"
#include "root_range.hpp"

namespace vcell {

/// The coefficients of a form in one number type.
template <class T>
class RadialHeight {
public:
    /// `convert` takes an Exact to T. `around`: over a cylinder, the unit of y.
    template <class Convert>
    RadialHeight(const RadialForm& form, Convert&& convert, const AxialTips& tips = {},
                 std::optional<double> around = std::nullopt)
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
        if (has_root_ && form.a0.sign() == Sign::Zero && (is_hollow_ || may_have_tips()))
            by_tips_.emplace(c_, b0_, slope_, b_, a_, is_hollow_, around);
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
            if (C.sign() != Sign::Positive && (!has_root_ || is_hollow_)) return unknown();
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
        if (is_hollow_ || C.sign() != Sign::Positive)
            return jet_with_tips<order>(n, B, A, C, around ? &C_y : nullptr);
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
        const double R = std::sqrt(std::max(0.0, B * B + A * A * C)),
                     f = B < 0 ? -A * A / (R - B) : -(B + R) / C;
        return {f, m * (f * B_x - A * A_x) / R, f * (0.5 * C_y * f + B_y) / R};
    }

private:
    template <int order>
    [[gnu::noinline]] FunctionJet<T> jet_with_tips(const RadialNormals<T>& n, const FunctionJet<T>& B,
                                                   const FunctionJet<T>& A, const T& C, const T* C_y) const {
        if (is_hollow_) return two_root_jet<order>(1, n, B, A, C, C_y);
        if (B.v.sign() != Sign::Negative) return unknown();
        if (C_y == nullptr) return two_root_jet<order>(-1, n, -B, A, -C, nullptr);
        const T minus_C_y = -*C_y;
        return two_root_jet<order>(-1, n, -B, A, -C, &minus_C_y);
    }
    // f = -(B + side R) / C, where C f^2 + 2 B f + A^2 = 0 and B > 0, over a sphere, where C is constant:
    // with s = B / R and k = A / R, R^2 = B^2 - A^2 C,
    //
    //     side f_u = (f / R) B_u + k A_u,   side R f_uv = B_uv f + A A_uv + D_u D_v,   D_u = k B_u - s A_u,
    //
    // as s^2 - 1 = C k^2; f / R is -(1 + s) / C on side 1. Around a cylinder, where C depends on y by C_y and
    // A does not, w = B_y + C_y f / 2 takes the place of B_y as in plain_jet(), and what is added is the
    // same. Where R may vanish nothing is said but f itself. Pre: C > 0 on side 1.
    template <int order>
    FunctionJet<T> two_root_jet(int side, const RadialNormals<T>& n, const FunctionJet<T>& B,
                                const FunctionJet<T>& A, const T& C, const T* C_y = nullptr) const {
        const T A2 = square(A.v);
        const bool is_larger = side > 0;
        FunctionJet<T> f;
        f.v = -(is_larger ? hollow_root_range(B.v, A2, C) : smaller_root_range(B.v, A2, C));
        if constexpr (order > 0) {
            T s = hollow_share(B.v, B.v, A2, C), k = hollow_share(A.v, B.v, A2, C),
              R = hollow_root(B.v, A2, C);
            bool is_next_to_tip = false;
            if (by_tips_ && (4 * R.upper() < B.v.upper() || 2 * R.lower() < R.upper())) {
                R = narrower(R, (*by_tips_)(n, B.v, A2));
                is_next_to_tip = R.sign() == Sign::Positive;
                if (is_next_to_tip) {
                    s = narrower(s, B.v / R);
                    k = narrower(k, A.v / R);
                    f.v = narrower(f.v, is_larger ? -((B.v + R) / C) : -(A2 / (B.v + R)));
                }
            }
            if (!is_bounded(s) || !is_bounded(k)) {
                f.x = f.y = f.xx = f.xy = f.yy = T::whole();
                return f;
            }
            const T slope = is_larger ? (T(1.0) + s) / C : f.v / R, of_A = is_larger ? k : -k;
            f.x = of_A * A.x - slope * B.x;
            const T signed_R = is_larger ? R : -R;
            // What is divided by R vanishes in the tip, and s and k grow: taken together, terms cancel.
            const auto together = [&](const T& apart, const auto& numerator, const T& divisor) {
                return is_next_to_tip ? narrower(apart, numerator() / divisor) : apart;
            };
            f.x = together(
                f.x, [&] { return B.x * f.v + A.v * A.x; }, signed_R);
            const T half_C_y = C_y != nullptr ? 0.5 * *C_y : T(0.0),
                    w = C_y != nullptr ? B.y + half_C_y * f.v : B.y;
            f.y = C_y != nullptr ? -(slope * w) : of_A * A.y - slope * B.y;
            if (C_y == nullptr)
                f.y = together(
                    f.y, [&] { return B.y * f.v + A.v * A.y; }, signed_R);
            if constexpr (order > 1) {
                const T D_x = together(
                    k * B.x - s * A.x, [&] { return A.v * B.x - B.v * A.x; }, R);
                f.xx = (B.xx * f.v + A.v * A.xx + square(D_x)) / signed_R;
                if (C_y != nullptr) {
                    const T D_y = k * w, half_C_yy = is_larger ? c_[2] : -c_[2];
                    f.xy = ((B.xy + half_C_y * f.x) * f.v + D_x * D_y) / signed_R;
                    f.yy = (half_C_yy * square(f.v) + *C_y * (f.v * f.y) + square(D_y)) / signed_R;
                    return f;
                }
                const T D_y = together(
                    k * B.y - s * A.y, [&] { return A.v * B.y - B.v * A.y; }, R);
                f.xy = (B.xy * f.v + A.v * A.xy + D_x * D_y) / signed_R;
                f.yy = (B.yy * f.v + A.v * A.yy + square(D_y)) / signed_R;
            }
        }
        return f;
    }
    static T narrower(const T& a, const T& b) {
        return {std::max(a.lower(), b.lower()), std::min(a.upper(), b.upper())};
    }
    static bool is_bounded(const T& t) {
        return t.lower() > T::whole().lower() && t.upper() < T::whole().upper();
    }
    // Pre: the root does not vanish.
    static T hollow_root(const T& B, const T& A2, const T& C) {
        return hull(sqrt(square(bottom(B)) - top(A2) * top(C)),
                    sqrt(square(top(B)) - with_greatest_root(A2, C) * bottom(C)));
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

    // May C be less than 0 anywhere?
    bool may_have_tips() const {
        return c_[0].sign() != Sign::Positive ||
               (c_[2].sign() != Sign::Zero && (4.0 * c_[0] * c_[2] - square(c_[1])).sign() != Sign::Positive);
    }

    bool has_root_;
    bool is_hollow_ = false;
    std::optional<RootByTips<T>> by_tips_;
    AxialTips tips_;
    std::optional<AxialEnd> own_tip_;  // the form's C is linear and falls towards it
    std::array<T, 3> c_, b_, a_;
    T b0_, slope_, a0_, c_at_tip_;
    // b, a, slope and c again, as they are evaluated around a cylinder.
    LinearOfNormals<T> around_b_, around_a_;
    NumberBall<T> axial_slope_;
    QuadraticOf<T> along_axis_;
};

}  // namespace vcell
