#include "touching.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace vcell {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

using Gradient = std::array<Interval, 2>;

Interval along(const Vector2d& d, const Gradient& g) {
    return Interval(d.x()) * g[0] + Interval(d.y()) * g[1];
}

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

    std::optional<Touching> find() {
        const Gradient F = heights_.gradient_difference(f_, g_, x_, y_),
                       hf = heights_.gradient_difference(h_, f_, x_, y_),
                       hg = heights_.gradient_difference(h_, g_, x_, y_);
        d_ = Vector2d(F[0].mid(), F[1].mid()).normalized();
        if (!d_.allFinite()) return std::nullopt;
        e_ = Vector2d(-d_.y(), d_.x());
        const Interval Fn = along(d_, F), rise = along(d_, hg);
        if (!(Fn.lower() > 0 && rise.lower() > 0 && along(d_, hf).upper() < 0)) return std::nullopt;

        const double l = rise.mid() / Fn.mid();
        const auto of_f = heights_.curvature(f_, x_, y_), of_g = heights_.curvature(g_, x_, y_);
        const auto FF = of_f - of_g, DD = heights_.curvature(h_, x_, y_) - of_g - l * FF;
        const Interval slope = -along(e_, F) / Fn;
        const auto second = [&](const HeightCurvature<Interval>& c) {
            return bend(c, e_, e_) + 2.0 * bend(c, e_, d_) * slope + bend(c, d_, d_) * square(slope);
        };
        bend_ = (second(DD) - (rise - l * Fn) * second(FF) / Fn).lower();
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
        if (slope_at(*low) == Sign::Positive) return touching(*low);
        if (slope_at(*high) == Sign::Negative) return touching(*high);
        const auto flat = solve([&](const Jets& j) { return j.turn(); },
                                [&](const Vector2d& p) { return turn_gradient(p); });
        return flat ? std::optional(touching(*flat)) : std::nullopt;
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
    Touching touching(const Point& p) const {
        const Jets j = jets(p);
        const Wide gap = j.h.v - j.g.v;
        const Vector2d place = middle(p);
        const Interval run = sqrt(Interval(2.0) * Interval(gap.enclosure().magnitude()) / Interval(bend_));
        const auto rounding = [&](int k) {
            return Interval((p[k] - Wide(place[k])).enclosure().magnitude());
        };
        return {p, place, gap, j.g.v, (run * stretch_ + rounding(0) + rounding(1)).upper()};
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

    // Newton's method for F = 0 and another equation: all digits, with derivatives in doubles.
    template <class Value, class Slope>
    std::optional<Point> solve(Value&& value, Slope&& slope) const {
        constexpr int most_steps = 40, enough = -230;
        Point p{Wide(0.5 * (box_[0] + box_[1])), Wide(0.5 * (box_[2] + box_[3]))};
        const int size = Wide(std::max(x_.radius(), y_.radius())).magnitude_exponent();
        for (int i = 0; i < most_steps; ++i) {
            const Vector2d m = middle(p);
            if (!x_.contains(m.x()) || !y_.contains(m.y())) return std::nullopt;
            Matrix2d rows;
            rows.row(0) = gradient(f_, g_, m);
            rows.row(1) = slope(m);
            const Matrix2d inverse = rows.inverse();
            if (!inverse.allFinite()) return std::nullopt;
            const Jets j = jets(p);
            const std::array<Wide, 2> residual{j.F(), value(j)};
            int largest = std::numeric_limits<int>::min();
            for (const int k : {0, 1}) {
                const Wide step = Wide(inverse(k, 0)) * residual[0] + Wide(inverse(k, 1)) * residual[1];
                p[k] = (p[k] - step).mid();
                largest = std::max(largest, step.magnitude_exponent());
            }
            if (largest < size + enough) return p;
        }
        return std::nullopt;
    }

    const Heights& heights_;
    const FormId h_, f_, g_;
    const std::array<double, 4> box_;
    Interval x_, y_;  // the surroundings
    Vector2d d_, e_;
    double bend_ = 0, stretch_ = 0;  // at least phi'', at most the trisector's length over a unit of s
};

}  // namespace

bool meet_nowhere(const Heights& heights, FormId h, FormId f, FormId g, const std::array<double, 4>& box) {
    // n along the coordinate along which the trisector is thin, with surroundings as wide again; s along the other.
    const double dx = box[1] - box[0], dy = box[3] - box[2];
    const std::size_t n = dx <= dy ? 0 : 1, s = 1 - n;
    const double margin = n == 0 ? dx : dy;
    std::array<Interval, 2> at{Interval(box[0], box[1]), Interval(box[2], box[3])};
    at[n] = Interval(at[n].lower() - margin, at[n].upper() + margin);
    const auto difference = [&](FormId a, FormId b, const std::array<Wide, 2>& p) {
        return heights.plain_value(a, p[0], p[1]) - heights.plain_value(b, p[0], p[1]);
    };
    std::array<Wide, 2> p{Wide(at[0].mid()), Wide(at[1].mid())};
    const Gradient F = heights.plain_gradient_difference(f, g, at[0], at[1]);
    Wide residual = difference(f, g, p);
    if ((residual.enclosure() + F[0] * (at[0] - Interval(at[0].mid())) + F[1] * (at[1] - Interval(at[1].mid()))).sign())
        return true;  // the two are equal nowhere
    const double inverse = 1 / F[n].mid();
    if (!F[n].sign() || !std::isfinite(inverse)) return false;
    const Interval run = -F[s] / F[n];

    constexpr int most_steps = 20, enough = -200;
    const int size = Wide(margin).magnitude_exponent();
    for (int i = 0;; ++i) {
        const Wide step = Wide(inverse) * residual;
        if (step.magnitude_exponent() < size + enough) break;
        if (i == most_steps) return false;
        p[n] = (p[n] - step).mid();
        if (!at[n].contains(p[n].approximation())) return false;
        residual = difference(f, g, p);
    }
    const Interval half(at[s].radius());
    const Interval reach = p[n].enclosure() + run * Interval(-1.0, 1.0) * half;
    if (!at[n].contains(reach.lower()) || !at[n].contains(reach.upper())) return false;

    const Gradient H = heights.plain_gradient_difference(h, g, at[0], at[1]);
    const double l = H[n].mid() * inverse;
    const Interval change = H[s] - l * F[s] + (H[n] - l * F[n]) * run;
    const Interval off = Interval(residual.enclosure().magnitude()) / F[n] * H[n];  // of the true trisector
    const Interval phi = difference(h, g, p).enclosure();
    const double least = std::max(phi.lower(), -phi.upper());
    return Interval(least).lower() > (Interval(change.magnitude()) * half + off.magnitude()).upper();
}

std::optional<Touching> find_touching(const Heights& heights, FormId h, FormId f, FormId g,
                                      const std::array<double, 4>& box) {
    return TouchFinder(heights, h, f, g, box).find();
}

}  // namespace vcell
