// The difference of two heights in a box by Taylor's formula of second order about its middle: what follows
// from it without asking for heights again.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>

#include "../../primitives/forms/heights.hpp"

namespace vcell {

struct HeightDifference {
    Interval v, gx, gy;                   // at the middle
    HeightCurvature<Interval> curvature;  // all over the box
    Interval dx, dy;                      // the box less its middle

    // This is a - b, whose jets are those at the middle; `over` is the difference of curvatures all over the
    // box.
    HeightDifference(const HeightJet<Interval>& a, const HeightJet<Interval>& b,
                     const HeightCurvature<Interval>& over, const Interval& x, const Interval& y)
        : v(a.v - b.v), gx(a.gx - b.gx), gy(a.gy - b.gy), curvature(over), dx(x), dy(y) {}

    // That of twins, which is told at once (primitives/forms/twins.hpp).
    HeightDifference(const FunctionJet<Interval>& at_middle, const HeightCurvature<Interval>& over,
                     const Interval& x, const Interval& y)
        : v(at_middle.v), gx(at_middle.x), gy(at_middle.y), curvature(over), dx(x), dy(y) {}

    // Where the offsets from the middle are these.
    std::array<Interval, 2> gradient(const Interval& x, const Interval& y) const {
        return {gx + curvature.xx * x + curvature.xy * y, gy + curvature.xy * x + curvature.yy * y};
    }
    Interval value(const Interval& x, const Interval& y) const {
        return v + gx * x + gy * y +
               0.5 * (curvature.xx * square(x) + 2.0 * (curvature.xy * x * y) + curvature.yy * square(y));
    }
    // The derivative along d all over the box: what the second ones share is taken together first.
    Interval slope_along(const Eigen::Vector2d& d) const {
        return d.x() * gx + d.y() * gy + (d.x() * curvature.xx + d.y() * curvature.xy) * dx +
               (d.x() * curvature.xy + d.y() * curvature.yy) * dy;
    }
    // Is it strictly concave all over the box along some direction, that of the second derivatives' least
    // eigenvalue?
    bool is_concave_somewhere() const {
        const double xx = curvature.xx.mid(), xy = curvature.xy.mid(), yy = curvature.yy.mid(),
                     angle = 0.5 * std::atan2(2 * xy, xx - yy), x = -std::sin(angle), y = std::cos(angle);
        return ((x * x) * curvature.xx + (2 * x * y) * curvature.xy + (y * y) * curvature.yy).upper() < 0;
    }
    bool is_convex() const {
        const Interval &xx = curvature.xx, &yy = curvature.yy;
        return xx.lower() > 0 && yy.lower() > 0 && (xx * yy - square(curvature.xy)).lower() > 0;
    }
    // About where its gradient vanishes, as an offset from the middle, if not far beyond the box; what it is
    // there about.
    struct Stationary {
        Eigen::Vector2d offset;
        double value;
    };
    Stationary stationary() const {
        const double xx = curvature.xx.mid(), xy = curvature.xy.mid(), yy = curvature.yy.mid(), x = gx.mid(),
                     y = gy.mid(), det = xx * yy - xy * xy;
        const Eigen::Vector2d to((xy * y - yy * x) / det, (xy * x - xx * y) / det);
        return {to, v.mid() + 0.5 * (x * to.x() + y * to.y())};
    }
};

// The offsets of a part of the box outside of which p = q = 0 has no solution in it; none if it has none at
// all. With Y about the inverse of the gradients at the middle the two say
//
//     d = -Y (p, q)(middle) - (Y grad (p, q)(middle) - 1) d - 1/2 d^T (Y D^2 (p, q)) d,
//
// so that known offsets bound others.
inline std::optional<std::array<Interval, 2>> common_zeros(const HeightDifference& p,
                                                           const HeightDifference& q) {
    constexpr int most_rounds = 4;
    constexpr double worth_another = 0.75;
    std::array<Interval, 2> d{p.dx, p.dy};
    const double a = p.gx.mid(), b = p.gy.mid(), c = q.gx.mid(), e = q.gy.mid(), det = a * e - b * c;
    const double inverse[2][2] = {{e / det, -b / det}, {-c / det, a / det}};
    struct Row {
        Interval rest, x, y, xx, xy, yy;
    };
    std::array<Row, 2> rows;
    for (const int i : {0, 1}) {
        const double s = inverse[i][0], t = inverse[i][1];
        if (!std::isfinite(s) || !std::isfinite(t)) return d;
        rows[i] = {s * p.v + t * q.v,
                   s * p.gx + t * q.gx - Interval(i == 0 ? 1.0 : 0.0),
                   s * p.gy + t * q.gy - Interval(i == 1 ? 1.0 : 0.0),
                   s * p.curvature.xx + t * q.curvature.xx,
                   s * p.curvature.xy + t * q.curvature.xy,
                   s * p.curvature.yy + t * q.curvature.yy};
    }
    for (int round = 0; round < most_rounds; ++round) {
        const auto [x, y] = d;
        const Interval xx = 0.5 * square(x), xy = x * y, yy = 0.5 * square(y);
        for (const int i : {0, 1}) {
            const Row& r = rows[i];
            const Interval at = -(r.rest + r.x * x + r.y * y + r.xx * xx + r.xy * xy + r.yy * yy);
            const double low = std::max(d[i].lower(), at.lower()), high = std::min(d[i].upper(), at.upper());
            if (!(low <= high)) {
                if (low > high) return std::nullopt;
                return std::array{p.dx, p.dy};
            }
            d[i] = {low, high};
        }
        if (!(d[0].width() * d[1].width() < worth_another * x.width() * y.width())) break;
    }
    return d;
}

}  // namespace vcell
