#include "touching.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <type_traits>

#include "../../core/solver/newton/newton.hpp"
#include "mixed_terms.hpp"

namespace vcell {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Interval bend(const HeightCurvature<Interval>& c, const Vector2d& u, const Vector2d& v) {
    return Interval(u.x()) * v.x() * c.xx + (Interval(u.x()) * v.y() + Interval(u.y()) * v.x()) * c.xy +
           Interval(u.y()) * v.y() * c.yy;
}

HeightCurvature<Interval> operator*(double k, const HeightCurvature<Interval>& a) {
    return {k * a.xx, k * a.xy, k * a.yy};
}

class TouchFinder {
public:
    TouchFinder(const Heights& heights, FormId h, FormId f, FormId g, const std::array<double, 4>& box)
        : heights_(heights), h_(h), f_(f), g_(g), box_(box) {
        const double margin = std::max(box[1] - box[0], box[3] - box[2]);
        x_ = Interval(box[0] - margin, box[1] + margin);
        y_ = Interval(box[2] - margin, box[3] + margin);
    }

    // turned: phi is asked to be concave, not convex.
    std::optional<Touching> find(bool turned = false) {
        const Sign inside = turned ? Sign::Positive : Sign::Negative;  // of phi between its zeros
        const std::array<Interval, 2> F = heights_.gradient_difference(f_, g_, x_, y_),
                                      hf = heights_.gradient_difference(h_, f_, x_, y_),
                                      hg = heights_.gradient_difference(h_, g_, x_, y_);
        d_ = Vector2d(F[0].mid(), F[1].mid()).normalized();
        if (!d_.allFinite()) return std::nullopt;
        e_ = Vector2d(-d_.y(), d_.x());
        const Interval Fn = derivative(d_, F), rise = derivative(d_, hg);
        least_rise_ = std::min(rise.lower(), -derivative(d_, hf).upper());
        if (!(Fn.lower() > 0 && least_rise_ > 0)) return std::nullopt;

        const double l = rise.mid() / Fn.mid();
        const auto of_f = heights_.curvature(f_, x_, y_), of_g = heights_.curvature(g_, x_, y_);
        const auto FF = of_f - of_g, DD = heights_.curvature(h_, x_, y_) - of_g - l * FF;
        const Interval slope = -derivative(e_, F) / Fn;
        const auto second = [&](const HeightCurvature<Interval>& c) {
            return bend(c, e_, e_) + 2.0 * bend(c, e_, d_) * slope + bend(c, d_, d_) * square(slope);
        };
        const Interval bending = second(DD) - (rise - l * Fn) * second(FF) / Fn;
        bend_ = turned ? -bending.upper() : bending.lower();
        if (!(bend_ > 0)) return std::nullopt;
        stretch_ = sqrt(Interval(1.0) + square(slope)).upper();
        if (!is_near()) return std::nullopt;

        const Interval s =
            Interval(e_.x()) * Interval(box_[0], box_[1]) + Interval(e_.y()) * Interval(box_[2], box_[3]);
        const auto low = at(s.lower()), high = at(s.upper());
        if (!low || !high) return std::nullopt;
        // All of the trisector between them is in the surroundings.
        const Vector2d from = middle(*low);
        const Interval run(0.0, Interval::up(s.upper() - s.lower()));
        for (const int k : {0, 1}) {
            const Interval reach = Interval(from[k]) + (Interval(e_[k]) + Interval(d_[k]) * slope) * run;
            const Interval& room = k == 0 ? x_ : y_;
            if (!room.contains(reach.lower()) || !room.contains(reach.upper())) return std::nullopt;
        }
        if (slope_at(*low) == -inside) return turned ? std::nullopt : std::optional(touching(*low));
        if (slope_at(*high) == inside) return turned ? std::nullopt : std::optional(touching(*high));
        const auto flat = solve([&](const Jets& j) { return j.turn(); },
                                [&](const Vector2d& p) { return turn_gradient(p); });
        if (!flat) return std::nullopt;
        Touching result = touching(*flat);
        if (result.gap.sign() == inside && sign_at(*low) == -inside && sign_at(*high) == -inside)
            result.lens = lens(result);
        return result;
    }

private:
    using Point = std::array<Wide, 2>;

    struct Jets {
        Point at;
        HeightJet<Wide> f, g, h;

        Wide F() const { return f.v - g.v; }
        // phi' times F_n.
        Wide turn() const { return (h.gy - g.gy) * (f.gx - g.gx) - (h.gx - g.gx) * (f.gy - g.gy); }
    };
    Jets jets(const Point& p) const {
        return {p, heights_.jet(f_, p[0], p[1]), heights_.jet(g_, p[0], p[1]), heights_.jet(h_, p[0], p[1])};
    }
    static Vector2d middle(const Point& p) { return {p[0].approximation(), p[1].approximation()}; }
    std::optional<Sign> slope_at(const Point& p) const { return jets(p).turn().sign(); }
    std::optional<Sign> sign_at(const Point& p) const {
        const Jets j = jets(p);
        return (j.h.v - j.g.v).sign();
    }
    // From farther out than the zeros of phi, which bends one way: so Newton's method comes nearer with every
    // step.
    std::optional<Touching::Lens> lens(const Touching& lowest) const {
        const double gap = lowest.gap.enclosure().magnitude();
        Touching::Lens lens;
        for (const int k : {0, 1}) {
            const Vector2d start = lowest.place + (k == 0 ? -1 : 1) * std::sqrt(2 * gap / bend_) * e_;
            const auto end = solve([](const Jets& j) { return j.h.v - j.g.v; },
                                   [&](const Vector2d& p) { return gradient(h_, g_, p); },
                                   {Wide(start.x()), Wide(start.y())});
            if (!end) return std::nullopt;
            lens.ends[k] = middle(*end);
        }
        lens.thickness = (Interval(gap) / Interval(least_rise_)).upper();
        return lens;
    }
    Touching touching(const Point& p) const {
        const Jets j = jets(p);
        const Wide gap = j.h.v - j.g.v;
        const Vector2d place = middle(p);
        const Interval run = sqrt(Interval(2.0) * Interval(gap.enclosure().magnitude()) / Interval(bend_));
        const auto rounding = [&](int k) {
            return Interval((p[k] - Wide(place[k])).enclosure().magnitude());
        };
        return {p, place, gap, j.g.v, (run * stretch_ + rounding(0) + rounding(1)).upper(), d_, {}};
    }

    Vector2d gradient(FormId a, FormId b, const Vector2d& p) const {
        const Interval x(p.x()), y(p.y());
        const auto i = heights_.jet(a, x, y), j = heights_.jet(b, x, y);
        return {(i.gx - j.gx).mid(), (i.gy - j.gy).mid()};
    }
    Vector2d turn_gradient(const Vector2d& p) const {
        const Interval x(p.x()), y(p.y());
        const auto of_g = heights_.curvature(g_, x, y), a = heights_.curvature(h_, x, y) - of_g,
                   b = heights_.curvature(f_, x, y) - of_g;
        const Vector2d u = gradient(h_, g_, p), v = gradient(f_, g_, p);
        return {a.xy.mid() * v.x() + u.y() * b.xx.mid() - a.xx.mid() * v.y() - u.x() * b.xy.mid(),
                a.yy.mid() * v.x() + u.y() * b.xy.mid() - a.xy.mid() * v.y() - u.x() * b.yy.mid()};
    }

    std::optional<Point> at(double s) const {
        return solve([&](const Jets& j) { return Wide(e_.x()) * j.at[0] + Wide(e_.y()) * j.at[1] - Wide(s); },
                     [&](const Vector2d&) { return e_; });
    }
    // In doubles: does h come near to the others? If not, smaller boxes tell them apart at less expense.
    bool is_near() const {
        constexpr double near = 0x1p-24;
        constexpr int most_steps = 4;
        Vector2d p(0.5 * (box_[0] + box_[1]), 0.5 * (box_[2] + box_[3]));
        for (int i = 0;; ++i) {
            const Interval x(p.x()), y(p.y());
            const auto f = heights_.jet(f_, x, y), g = heights_.jet(g_, x, y), h = heights_.jet(h_, x, y);
            if (i == most_steps) return !(std::abs((h.v - g.v).mid()) > near * std::abs(g.v.mid()));
            Matrix2d rows;
            rows << (f.gx - g.gx).mid(), (f.gy - g.gy).mid(), 0, 0;
            rows.row(1) = turn_gradient(p);
            const double turn = ((h.gy - g.gy) * (f.gx - g.gx) - (h.gx - g.gx) * (f.gy - g.gy)).mid();
            p -= rows.inverse() * Vector2d((f.v - g.v).mid(), turn);
            if (!p.allFinite()) return true;
            p = {std::clamp(p.x(), x_.lower(), x_.upper()), std::clamp(p.y(), y_.lower(), y_.upper())};
        }
    }

    // F = 0 and another equation, to all digits, with derivatives in doubles.
    template <class Value, class Slope>
    std::optional<Point> solve(Value&& value, Slope&& slope) const {
        return solve(value, slope, {Wide(0.5 * (box_[0] + box_[1])), Wide(0.5 * (box_[2] + box_[3]))});
    }
    template <class Value, class Slope>
    std::optional<Point> solve(Value&& value, Slope&& slope, const Point& start) const {
        constexpr int most_steps = 40, enough = -230;
        const auto linearise = [&](const Point& p) {
            const Vector2d m = middle(p), across = gradient(f_, g_, m), along = slope(m);
            const Jets j = jets(p);
            return LocalModel<Wide, 2>{
                {j.F(), value(j)},
                {{{Wide(across.x()), Wide(across.y())}, {Wide(along.x()), Wide(along.y())}}}};
        };
        const double small = std::ldexp(std::max(x_.radius(), y_.radius()), enough);
        const auto near = approach<Wide, 2>(LinearisedModel<Wide, 2, decltype(linearise)>(linearise), start,
                                            {x_, y_}, small, most_steps);
        return near ? std::optional(near->point) : std::nullopt;
    }

    const Heights& heights_;
    const FormId h_, f_, g_;
    const std::array<double, 4> box_;
    Interval x_, y_;  // the surroundings
    Vector2d d_, e_;
    double bend_ = 0, stretch_ = 0;  // at least |phi''|, at most the trisector's length over a unit of s
    double least_rise_ = 0;          // of h - g and f - h along d
};

// meet_nowhere(): along the trisector f = g, a graph n(s) over the box, h - g changes by less than it is in
// its middle: heights without the distances from tips, or times these.
class MeetingSearch {
public:
    MeetingSearch(const Heights& heights, bool is_plain, FormId h, FormId f, FormId g,
                  const std::array<double, 4>& box)
        : heights_(heights),
          is_plain_(is_plain),
          h_(h),
          f_(f),
          g_(g),
          at_{Interval(box[0], box[1]), Interval(box[2], box[3])} {
        // n along the coordinate along which the trisector is thin, with surroundings as wide again; s along
        // the other.
        const double dx = box[1] - box[0], dy = box[3] - box[2];
        n_ = dx <= dy ? 0 : 1;
        margin_ = std::min(dx, dy);
        at_[n_] = Interval(at_[n_].lower() - margin_, at_[n_].upper() + margin_);
    }

    // None where rounding leaves the question open.
    std::optional<bool> in_doubles() {
        const std::size_t s = 1 - n_;
        const std::array<Interval, 2> F = heights_.plain_gradient_difference(f_, g_, at_[0], at_[1]);
        const std::array<Interval, 2> middle{Interval(at_[0].mid()), Interval(at_[1].mid())};
        if ((difference(f_, g_, middle) + F[0] * (at_[0] - middle[0]) + F[1] * (at_[1] - middle[1])).sign())
            return true;  // the two are equal nowhere
        inverse_ = 1 / F[n_].mid();
        if (!F[n_].sign() || !std::isfinite(inverse_)) return false;
        slope_ = F[n_];
        run_ = -F[s] / F[n_];
        half_ = Interval(at_[s].radius());

        const std::array<Interval, 2> H = is_plain_
                                              ? heights_.plain_gradient_difference(h_, g_, at_[0], at_[1])
                                              : heights_.gradient_difference(h_, g_, at_[0], at_[1]);
        across_ = H[n_];
        const double l = H[n_].mid() * inverse_;
        change_ = Interval((H[s] - l * F[s] + (H[n_] - l * F[n_]) * run_).magnitude()) * half_;
        return ask<Interval>(most_double_steps, double_enough);
    }
    // Pre: in_doubles() had no answer.
    bool in_many_digits() const { return ask<Wide>(most_steps, enough).value_or(false); }

private:
    static constexpr int most_steps = 20, enough = -200, most_double_steps = 6, double_enough = -40;

    Interval difference(FormId a, FormId b, const std::array<Interval, 2>& p) const {
        return heights_.plain_jet(a, p[0], p[1]).v - heights_.plain_jet(b, p[0], p[1]).v;
    }
    Wide difference(FormId a, FormId b, const std::array<Wide, 2>& p) const {
        return heights_.plain_value(a, p[0], p[1]) - heights_.plain_value(b, p[0], p[1]);
    }
    template <class T>
    T rise(const std::array<T, 2>& p) const {  // h - g
        return is_plain_ ? difference(h_, g_, p)
                         : heights_.value(h_, p[0], p[1]) - heights_.value(g_, p[0], p[1]);
    }
    static Interval enclosure(const Interval& x) { return x; }
    static Interval enclosure(const Wide& x) { return x.enclosure(); }
    static Interval middle(const Interval& x) { return Interval(x.mid()); }
    static Wide middle(const Wide& x) { return x.mid(); }

    // None: digits were not enough.
    template <class T>
    std::optional<bool> ask(int steps, int exponent) const {
        std::array<T, 2> p{T(at_[0].mid()), T(at_[1].mid())};
        T residual = difference(f_, g_, p);
        const double small = std::ldexp(margin_, exponent);
        for (int i = 0;; ++i) {
            const T step = T(inverse_) * residual;
            if (enclosure(step).magnitude() <= small) break;
            if (i == steps) {
                if constexpr (std::is_same_v<T, Wide>) return std::nullopt;
                break;
            }
            p[n_] = middle(p[n_] - step);
            if (!at_[n_].contains(enclosure(p[n_]).mid())) return false;
            residual = difference(f_, g_, p);
        }
        const Interval reach = enclosure(p[n_]) + run_ * Interval(-1.0, 1.0) * half_;
        if (!at_[n_].contains(reach.lower()) || !at_[n_].contains(reach.upper())) return false;
        const Interval off =
            Interval(enclosure(residual).magnitude()) / slope_ * across_;  // of the true trisector
        const Interval phi = enclosure(rise(p));
        const double least = least_magnitude(phi);
        if (Interval(least).lower() > (change_ + off.magnitude()).upper()) return true;
        if (phi.magnitude() + off.magnitude() < change_.lower()) return false;
        return std::nullopt;
    }

    const Heights& heights_;
    const bool is_plain_;  // h - g
    const FormId h_, f_, g_;
    std::array<Interval, 2> at_;  // the box and its surroundings
    std::size_t n_;
    double margin_, inverse_ = 0;
    Interval slope_, run_, half_, across_, change_;
};

}  // namespace

std::optional<Touching> find_pinch(const Heights& heights, FormId h, FormId f, FormId g,
                                   const std::array<double, 4>& box) {
    return TouchFinder(heights, h, f, g, box).find(true);
}

bool meet_nowhere(const Heights& heights, FormId h, FormId f, FormId g, const std::array<double, 4>& box,
                  Decisions& decisions) {
    const auto do_not_meet = [&](bool is_plain) {
        MeetingSearch search(heights, is_plain, h, f, g, box);
        if (const auto answer = search.in_doubles()) {
            ++decisions.by_interval;
            return *answer;
        }
        ++decisions.by_multiprecision;
        return search.in_many_digits();
    };
    // Where the heights of a side of the box grow towards its tip only their products tell how little it and
    // others differ along a trisector that comes to the tip, too.
    return do_not_meet(true) || (heights.family().tips.any() && do_not_meet(false));
}

std::optional<Touching> find_touching(const Heights& heights, FormId h, FormId f, FormId g,
                                      const std::array<double, 4>& box) {
    return TouchFinder(heights, h, f, g, box).find();
}

}  // namespace vcell
