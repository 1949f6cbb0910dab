#include "side_roots.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/errors.hpp"
#include "mixed_terms.hpp"

namespace vcell {

// A root along a side is found this much more finely, at least, than the stretch in which it is known to lie.
constexpr double root_width = 0x1p-12;
// How much steeper than the least slope a difference may be at its root, so that a guess is as good as a
// Newton step.
constexpr double most_steepening = 8;
constexpr int most_newton_steps = 30;

// The root of before - after, which is negative at s0 and positive at s1: Newton's method with bisection, in
// doubles.
SideRoots::Guess SideRoots::approximate_root(const SideLine& line, double s0, double s1, FormId before,
                                             FormId after) const {
    const double side_slope = line.slope.mid();
    const bool are_twins = heights_.are_twins(before, after);
    const double enough = 2 * std::numeric_limits<double>::epsilon() * std::max(std::abs(s0), std::abs(s1));
    Guess root{Interval(s0, s1).mid(), 0};
    for (int i = 0; i < most_newton_steps; ++i) {
        const IntervalPoint p = line.at(Interval(root.s));
        const double x = p[0].mid(), y = p[1].mid();
        const PointNormal n = supports_ ? PointNormal(x, y) : PointNormal();
        const auto difference = [&]() -> std::array<double, 3> {
            if (are_twins) {
                const HeightJet<Interval> d = heights_.difference(before, after, p[0], p[1]);
                return {d.v.mid(), d.gx.mid(), d.gy.mid()};
            }
            // Next to a tip only intervals take heights together without cancellation.
            const auto jet = [&](FormId f) {
                if (supports_) return supports_->jet(f, n);
                if (!heights_.family().tips.any()) return heights_.near(f, x, y);
                const HeightJet<Interval> j = heights_.jet(f, p[0], p[1]);
                return std::array{j.v.mid(), j.gx.mid(), j.gy.mid()};
            };
            const auto f = jet(before), g = jet(after);
            return {f[0] - g[0], f[1] - g[1], f[2] - g[2]};
        };
        const auto [v, dx, dy] = difference();
        root.slope = line.by_x ? dx + side_slope * dy : dy + side_slope * dx;
        (v < 0 ? s0 : s1) = root.s;
        const double step = v / root.slope, next = root.s - step;
        if (std::abs(step) <= enough) break;
        root.s = next > s0 && next < s1 ? next : Interval(s0, s1).mid();
    }
    return root;
}

// A guess, and its distance from the root by the mean value theorem; where that says little, interval Newton
// and bisection.
RimTransition SideRoots::locate(const SideLine& line, double s0, double s1, FormId before, FormId after,
                                double least_slope) {
    if (!rule_.shows_greater(before, after)) return locate_rise(line, s0, s1, before, after, least_slope);
    RimTransition t = locate_rise(line, s0, s1, after, before, least_slope);
    std::swap(t.before, t.after);
    return t;
}

// Likewise of before - after, negative at s0 and positive at s1.
RimTransition SideRoots::locate_rise(const SideLine& line, double s0, double s1, FormId before, FormId after,
                                     double least_slope) {
    const Guess guess = approximate_root(line, s0, s1, before, after);
    const IntervalPoint near = line.at(Interval(guess.s));
    double lo = s0, hi = s1;
    const auto is_narrow = [&] { return hi - lo <= root_width * (s1 - s0); };
    const auto narrow_by = [&](const Interval& residual) {
        const Interval root =
            Interval(guess.s) + Interval(-1.0, 1.0) * Interval(residual.magnitude()) / Interval(least_slope);
        lo = std::max(s0, root.lower());
        hi = std::min(s1, root.upper());
        if (!(lo <= hi)) throw InternalError("no root of a sign change along a side");
        return guess.slope <= most_steepening * least_slope && is_narrow();
    };
    bool found = false;
    const IntervalPoint stretch = line.at(Interval(s0, s1));
    if (all_.compare_by_supports(s1 - s0, all_.extent_at(stretch[0], stretch[1])) && is_point(near[0]) &&
        is_point(near[1]) && !heights_.are_twins(before, after)) {
        const PointNormal n(near[0].mid(), near[1].mid());
        const Interval residual =
            Interval::ball(supports_->value(before, n) - supports_->value(after, n),
                           supports_->value_error(before, n) + supports_->value_error(after, n));
        found = narrow_by(residual);
        if (!found && is_narrow()) {
            const IntervalPoint range = line.at(Interval(lo, hi));
            const NormalBox box(range[0].lower(), range[0].upper(), range[1].lower(), range[1].upper());
            const auto [gx, gy] = box.gradient(supports_->over(before, box), supports_->over(after, box));
            least_slope = std::max(least_slope, line.along({{}, gx, gy}).lower());
            found = narrow_by(residual);
        }
    }
    if (!found) found = narrow_by(heights_.value_difference(before, after, near[0], near[1]));
    const auto enclose = [&](const auto& difference) {
        const Interval root = enclose_zero(
            Interval(lo, hi), [&](const Interval& s) { return difference(s.lower()); },
            [&](const Interval& part) { return line.slope_difference(heights_, before, after, part); });
        lo = root.lower();
        hi = root.upper();
    };
    if (!found) enclose([&](double s) { return line.difference(heights_, before, after, s); });
    const bool is_sharp =
        !(found || is_narrow()) ||
        !all_.is_well_known({near[0].mid(), near[1].mid()}, hi - lo, std::array{before, after},
                            all_.extent_at(stretch[0], stretch[1]));
    if (is_sharp) enclose([&](double s) { return line.sharp_difference(heights_, before, after, s); });
    ++(is_sharp ? decisions_.by_multiprecision : decisions_.by_interval);
    const IntervalPoint p = line.at(Interval(lo, hi));
    return {before, after, {p[0].mid(), p[1].mid()}, reach(p[0], p[1]), {}};
}

}  // namespace vcell
