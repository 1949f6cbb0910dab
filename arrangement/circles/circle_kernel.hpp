/// Points and predicates on circles and lines that are given as {f = g} for CircularForms f, g.
///
/// Identity is combinatorial: a point is a pair of curves and an orientation. Where two curves of
/// forms meet there are at most two points, and their gradients turn opposite ways at the two, so
/// (curve, curve, sign of the turn) names one point. The crossing of {i = j} with {i = k} is the
/// crossing with {j = k}; nobody computes it three times and hopes that the results agree.
///
/// Every predicate climbs the ladder: double with a proven bound, interval, exact. The first two work
/// on a certified disk around the point (Newton-Kantorovich, see circle_kernel.cpp), the last in the
/// quadratic extension of Q in which the point lives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "../../core/curves/circular_form.hpp"
#include "../../core/ids.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/sign.hpp"

namespace vcell {

struct PointTag {
    static constexpr char letter = 'p';
};
using PointId = Id<PointTag>;

/// The curve {f = g}, directed so that f < g on its left.
struct FormPair {
    FormId f, g;

    FormPair reversed() const { return {g, f}; }
    friend bool operator==(FormPair, FormPair) = default;
};

/// An exact point in double clothes: the true point lies within `error` of (x, y).
struct KernelPoint {
    double x, y, error;
    FormPair first,
        second;  ///< equal: the circle's leftmost point, centre or rightmost point (by orientation)
    /// Sign of grad(first) x grad(second) at the point, grad being that of f - g; Zero where the two
    /// curves touch.
    Sign orientation;
};

// Rounding bounds of the first rung.
namespace kernel_bounds {

using roundoff::u;
constexpr double tiny = DBL_MIN;  // covers underflow in any bound below

// A form's value is computed with at most 13 relative roundings of the sum of absolute values of its
// terms (4 in a coefficient or in w, 5 in 1/w and the product with it, 4 in the terms and their sum), its
// gradient with at most 12, K with 6. The bounds themselves are computed with a handful of roundings.
constexpr double value_roundings = 16 * u;
constexpr double gradient_roundings = 16 * u;
constexpr double K_roundings = 8 * u;
static_assert(value_roundings >= (13 + 2) * u);
static_assert(gradient_roundings >= (12 + 2) * u);

// Bounds are sums and products of at most some twenty roundings; this covers them all.
constexpr double slop = 1 + 64 * u;

}  // namespace kernel_bounds

class CircleKernel {
public:
    /// Starts empty: no points, no forms but the zero form.
    CircleKernel() { reset(nullptr); }

    /// Forgets all forms and points (keeps memory and counts). `family` serves exact coefficients of
    /// forms added by add_form; it must outlive their use.
    void reset(const CircularFamily* family);

    /// The function 0: {line = zero} makes a line a curve.
    static constexpr FormId zero_form() { return {0}; }
    FormId add_line(double a, double b, double c);  ///< a x + b y + c, coefficients exact
    FormId add_form(FormId in_family);

    /// What the family calls this form; none for lines and zero.
    FormId family_id(FormId f) const { return sources_[f].in_family; }

    const KernelPoint& point(PointId p) const { return points_[p]; }
    std::size_t point_count() const { return points_.size(); }

    /// The point where the curves meet with that orientation, or none if they do not. `near` is a place
    /// near which the arithmetic is best conditioned; any finite one gives a correct answer.
    /// Pre: orientation is not Zero; the curves are not the same.
    std::optional<PointId> intersection(FormPair c, FormPair d, Sign orientation,
                                        const Eigen::Vector2d& near);
    /// The same if the first rung can prove it; none says nothing.
    std::optional<PointId> certain_intersection(FormPair c, FormPair d, Sign orientation,
                                                const Eigen::Vector2d& near) {
        if (const auto p = certified_intersection(c, d, orientation, near)) return points_.push_back(*p);
        return std::nullopt;
    }
    /// Positive: the curves cross in two points (one, if both are lines). Zero: they touch in one
    /// point. Negative: they do not meet. Pre: not the same curve.
    Sign intersection_sign(FormPair c, FormPair d, const Eigen::Vector2d& near);
    /// The point in which the curves touch. Pre: intersection_sign is Zero.
    PointId touching_point(FormPair c, FormPair d);
    /// The centre of a circle. Pre: c is not a line.
    PointId center_point(FormPair c) { return circle_point(c, Sign::Zero); }
    /// Leftmost point of a circle. Pre: radius_sign(c) is Positive and c is not a line.
    PointId leftmost_point(FormPair c) { return circle_point(c, Sign::Negative); }
    PointId rightmost_point(FormPair c) { return circle_point(c, Sign::Positive); }

    /// Do the two forms of c define the same curve as those of d? (Pencils: one curve for many pairs.)
    bool same_curve(FormPair c, FormPair d);
    /// Sign of K in f - g = K |p|^2 + ...: positive for circles run counter-clockwise, zero for lines.
    Sign curvature_sign(FormPair c);
    /// Positive: a circle; Zero: a single point; Negative: empty. For lines: Positive, or Negative if f - g
    /// is constant.
    Sign radius_sign(FormPair c);

    /// A form's value, gradient and quadratic coefficient at a place, with bounds on their errors.
    struct Jet {
        double v, gx, gy, K;
        double ev, eg, eK;
    };

    /// Sign of f - g at p.
    Sign sign_at(PointId p, FormId f, FormId g) {
        Jet at_point;
        return sign_at(p, f, g, at_point);
    }
    /// The same, and the jet of f - g at the double coordinates of p.
    Sign sign_at(PointId p, FormId f, FormId g, Jet& at_point);
    /// Sign of grad(c) x grad(d) at p, a point of both.
    Sign turn_at(PointId p, FormPair c, FormPair d);
    /// Lexicographic order of points.
    Sign compare_xy(PointId p, PointId q);
    Sign compare_x(PointId p, PointId q);
    Sign compare_y(PointId p, PointId q);
    /// Sign of y_p - (centre of c)_y. Pre: c is a circle.
    Sign side_of_center(PointId p, FormPair c);

    /// Does r lie on c strictly between p and q, going along c's direction? All three are points of c.
    /// For p == q: everything else on a circle does. r equal to p or q does not.
    bool strictly_between(FormPair c, PointId p, PointId q, PointId r);
    /// Branches leaving p along the directions of three curves through p: does `x` lie strictly inside
    /// the counter-clockwise sector from `from` to `to`? (from == to: the whole turn.)
    bool branch_in_sector(PointId p, FormPair from, FormPair x, FormPair to);

    /// Where c and d, through p, have parallel gradients there: the sign of d's f - g along c near p, on both
    /// sides of p alike. Zero: the same curve.
    Sign sign_beside_touching(PointId p, FormPair c, FormPair d) { return curvature_order(p, d, c); }
    /// Two branches leave p, the leftmost point of all there is, so neither goes left: does the sector from
    /// `from` counter-clockwise to `to` contain the direction to the left?
    bool sector_contains_left(PointId p, FormPair from, FormPair to);
    /// Do c and d, two directions of one curve through p, agree?
    bool same_direction(PointId p, FormPair c, FormPair d) { return along_sign(p, c, d) == Sign::Positive; }
    /// Does q come after p on the line c? Pre: c is a line, both points lie on it.
    bool precedes_on_line(FormPair c, PointId p, PointId q);

    struct ArcBounds {
        std::array<double, 4> box;  ///< {x0, x1, y0, y1}, contains the arc
        double chord,
            sagitta;  ///< upper bounds on the distance of the ends, and of any point from their segment
    };
    /// The arc of c from p to q (the whole circle for p == q, with an infinite sagitta).
    ArcBounds arc_bounds(FormPair c, PointId p, PointId q) const;
    /// A rectangle that contains the circle c; the whole plane where doubles cannot tell.
    std::array<double, 4> circle_box(FormPair c) const;
    /// Does the double rung prove that c's circle does not lie in the rectangle?
    bool circle_leaves_box(FormPair c, const std::array<double, 4>& box) const;

    /// Enclosure of f at the true point p: midpoint and radius.
    std::array<double, 2> height(FormId f, PointId p) const;
    /// f at a plain location in doubles with an error bound.
    std::array<double, 2> height(FormId f, double x, double y) const;

    /// Lower bound of f - g over the axis-parallel rectangle [x0,x1] x [y0,y1] (double rung only).
    double lower_bound(FormId f, FormId g, double x0, double x1, double y0, double y1) const;

    Decisions& decisions() { return decisions_; }
    const Decisions& decisions() const { return decisions_; }

    /// f with 1/w multiplied out: what the first rung evaluates.
    struct Form {
        double k, cx, cy, a, b, e, iw, K;
    };
    const Form& form(FormId f) const { return forms_[f]; }

    static Jet jet(const Form& f, double x, double y);
    static Form make_form(const CircularForm& f);
    /// add_form() of what make_form() has made of it.
    FormId add_form(FormId in_family, const Form& made);
    /// A form about the middle of a rectangle of half sides rx, ry: for quick comparisons over the whole of
    /// it.
    struct BoxForm {
        double v, gx, gy, K;
        double top;    ///< about the highest value in the rectangle
        double scale;  ///< bound on the sum of the absolute values of all terms anywhere in it
    };
    static BoxForm box_form(const Form& f, double x, double y, double rx, double ry);
    /// Is a form certainly above another one all over the rectangle? Plain arithmetic with one margin.
    static bool certainly_above(const BoxForm& f, const BoxForm& g, double rx, double ry) {
        return excess(f, g, rx, ry) > 0;
    }
    /// Positive if it is.
    static double excess(const BoxForm& f, const BoxForm& g, double rx, double ry);
    static bool certainly_above(const Form& f, const BoxForm& g, double x, double y, double rx, double ry) {
        return certainly_above(box_form(f, x, y, rx, ry), g, rx, ry);
    }

    /// Lower bound of f - g over |dx| <= rx, |dy| <= ry about the place where both jets were taken.
    static double lower_bound(const Jet& f, const Jet& g, double rx, double ry) {
        return lower_bound(difference(f, g), rx, ry);
    }
    /// The same for the jet of a difference.
    static double lower_bound(const Jet& difference, double rx, double ry);
    static Jet difference(const Jet& f, const Jet& g);

private:
    struct Source {
        FormId in_family;  // none: a line, its coefficients are exact in Form
        std::int32_t exact = -1;
    };
    // (px + rx sqrt(d), py + ry sqrt(d)) / w, w > 0
    struct ExactPoint {
        Exact px, rx, py, ry, d, w;
        // w^2 times the square of its distance from the origin, and w^2, once a value was asked for.
        struct Squares {
            OneRoot of_point;
            Exact of_w;
        };
        std::optional<Squares> squares{};
    };
    // K |p|^2 + A x + B y + C: a positive multiple of f - g.
    struct ExactCurve {
        Exact K, A, B, C;
    };

    Jet difference(FormPair c, double x, double y) const {
        return difference(jet(forms_[c.f], x, y), jet(forms_[c.g], x, y));
    }
    /// `moved`: away from a place where the closed form is singular.
    std::optional<KernelPoint> certified_intersection(FormPair c, FormPair d, Sign orientation,
                                                      const Eigen::Vector2d& near, bool moved = false) const;
    bool certify(KernelPoint& p) const;
    PointId add_exact_point(FormPair c, FormPair d, Sign orientation, ExactPoint exact);
    PointId circle_point(FormPair c, Sign which);
    ExactPoint exact_circle_point(FormPair c, Sign which);
    struct Circle {
        Interval cx, cy, r2;
    };
    std::optional<Circle> circle(FormPair c) const;
    const ExactForm& exact_form(FormId f);
    ExactCurve exact_curve(FormPair c);
    std::optional<ExactPoint> exact_intersection(const ExactCurve& c, const ExactCurve& d, Sign orientation);
    Exact exact_discriminant(const ExactCurve& c, const ExactCurve& d);
    ExactPoint& exact_point(PointId p);
    static OneRoot exact_value(const ExactCurve& c, ExactPoint& p);
    static std::array<OneRoot, 2> exact_gradient(const ExactCurve& c, const ExactPoint& p);
    int sector_of(PointId p, FormPair from, FormPair x);
    Sign along_sign(PointId p, FormPair c, FormPair d);
    Sign curvature_order(PointId p, FormPair c, FormPair d);
    bool share_line(PointId p, PointId q, double Form::*slope) const;
    Sign exact_line_order(const ExactCurve& line, PointId p, PointId q);
    bool exact_strictly_between(FormPair c, PointId p, PointId q, PointId r);

    const CircularFamily* family_ = nullptr;
    IdVector<FormId, Form> forms_;
    IdVector<FormId, Source> sources_;
    IdVector<PointId, KernelPoint> points_;
    std::deque<ExactForm> exact_forms_;
    std::vector<std::int32_t> exact_point_index_;
    std::deque<ExactPoint> exact_points_;
    Decisions decisions_;
};

// --- First rung: called for every pair of a form and a place, hence inline. -------------------------------

inline CircleKernel::Jet CircleKernel::jet(const Form& f, double x, double y) {
    using namespace kernel_bounds;
    const double dx = x - f.cx, dy = y - f.cy;
    const double r2 = f.k * (dx * dx + dy * dy), ax = f.a * x, by = f.b * y;
    const double kx = 2 * f.k * dx, ky = 2 * f.k * dy;
    Jet j;
    j.v = (r2 + (ax + by + f.e)) * f.iw;
    j.gx = (kx + f.a) * f.iw;
    j.gy = (ky + f.b) * f.iw;
    j.K = f.K;
    j.ev = value_roundings * ((std::abs(r2) + std::abs(ax) + std::abs(by) + std::abs(f.e)) * f.iw) + tiny;
    j.eg = gradient_roundings *
               ((std::max(std::abs(kx), std::abs(ky)) + std::max(std::abs(f.a), std::abs(f.b))) * f.iw) +
           tiny;
    j.eK = K_roundings * std::abs(f.K);
    return j;
}

inline CircleKernel::Jet CircleKernel::difference(const Jet& p, const Jet& q) {
    using namespace kernel_bounds;
    Jet d{p.v - q.v, p.gx - q.gx, p.gy - q.gy, p.K - q.K, 0, 0, 0};
    d.ev = (p.ev + q.ev + u * std::abs(d.v)) * slop;
    d.eg = (p.eg + q.eg + u * std::max(std::abs(d.gx), std::abs(d.gy))) * slop;
    d.eK = (p.eK + q.eK + u * std::abs(d.K)) * slop;
    return d;
}

inline double CircleKernel::lower_bound(const Jet& d, double rx, double ry) {
    using namespace kernel_bounds;
    const double K = d.K - d.eK;
    // Per coordinate: min over |t| <= r of K t^2 + G t, from below.
    const auto term = [&](double G, double r) {
        G = std::abs(G) + d.eg;
        if (G < 2 * K * r) return -G * G / (4 * K) * slop - tiny;
        const double t = (K * r - G) * r;
        return t - 8 * u * (std::abs(K) * r + G) * r - tiny;
    };
    const double low = d.v - d.ev + (term(d.gx, rx) + term(d.gy, ry));
    return low - 4 * u * (std::abs(d.v) + std::abs(low)) - tiny;
}

inline CircleKernel::BoxForm CircleKernel::box_form(const Form& f, double x, double y, double rx, double ry) {
    const double dx = x - f.cx, dy = y - f.cy;
    const double quadratic = f.k * (dx * dx + dy * dy), ax = f.a * x, by = f.b * y;
    BoxForm p;
    p.v = (quadratic + ax + by + f.e) * f.iw;
    p.gx = (2 * f.k * dx + f.a) * f.iw;
    p.gy = (2 * f.k * dy + f.b) * f.iw;
    p.K = f.K;
    const double change = std::abs(p.gx) * rx + std::abs(p.gy) * ry + std::abs(f.K) * (rx * rx + ry * ry);
    p.top = p.v + change;
    p.scale = (std::abs(quadratic) + std::abs(ax) + std::abs(by) + std::abs(f.e)) * f.iw + change;
    return p;
}

// Per coordinate K t^2 + G t >= -|G| r + (K r^2, where the minimum is at an end). Every quantity here is a
// sum of terms that `scale` bounds, with fewer than 40 roundings each.
inline double CircleKernel::excess(const BoxForm& f, const BoxForm& g, double rx, double ry) {
    const double K = f.K - g.K, Gx = std::abs(f.gx - g.gx), Gy = std::abs(f.gy - g.gy);
    const double curved = (Gx > 2 * K * rx ? K * rx * rx : 0) + (Gy > 2 * K * ry ? K * ry * ry : 0);
    return f.v - g.v - (Gx * rx + Gy * ry) + curved - 64 * DBL_EPSILON * (f.scale + g.scale);
}

}  // namespace vcell
