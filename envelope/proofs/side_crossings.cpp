#include "side_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "../../core/solver/newton/newton.hpp"
#include "mixed_terms.hpp"
#include "space_tie.hpp"

namespace vcell {

// Where the differences of the forms that follow each other rise all along a stretch, each is lowest once at
// most, from where it comes below the one before: the first one to do so is next. All of it with many digits,
// as the forms may follow each other closer than stretches can be told apart. None if slopes do not tell, or
// doubles not keep the places apart.
std::optional<std::vector<RimTransition>> SideCrossings::order(const SideLine& line, double s0, FormId l0,
                                                               double s1, FormId l1,
                                                               std::span<const FormId> forms) {
    if (!rule_.spares(forms)) return std::nullopt;
    constexpr int most_steps = 20, enough = -200;
    const double m = Interval(s0, s1).mid();
    // Where f and g are equal, f being lower before.
    const auto crossing = [&](FormId f, FormId g, const Interval& slope) -> std::optional<Wide> {
        const auto near =
            approach<Wide, 1>(of_one_unknown(
                                  [&](const Wide& s) {
                                      const auto p = line.wide_at(s);
                                      return heights_.value(f, p[0], p[1]) - heights_.value(g, p[0], p[1]);
                                  },
                                  slope.mid()),
                              {Wide(m)}, {Interval(s0, s1)}, std::ldexp(s1 - s0, enough), most_steps);
        if (!near) return std::nullopt;
        return near->point[0] - near->local.value[0] / Wide(slope);
    };
    std::vector<RimTransition> transitions;
    double after = s0;
    for (FormId current = l0; current != l1;) {
        std::optional<Wide> first;
        FormId next;
        bool is_told = true;
        for (const FormId f : forms) {
            if (f == current) continue;
            const Interval slope = line.slope_difference(heights_, current, f, Interval(s0, s1));
            if (!slope.sign()) return std::nullopt;
            if (slope.sign() != Sign::Positive) continue;
            const auto at_end =
                (line.sharp_height(heights_, current, s1) - line.sharp_height(heights_, f, s1)).sign();
            if (!at_end) return std::nullopt;
            if (at_end != Sign::Positive) continue;
            const auto s = crossing(current, f, slope);
            if (!s) return std::nullopt;
            const auto order = first ? (*s - *first).sign() : std::optional(Sign::Negative);
            if (order == Sign::Negative) is_told = true;
            if (!order || order == Sign::Zero) is_told = false;
            if (order != Sign::Positive) {
                first = s;
                next = f;
            }
        }
        if (!first || !is_told || transitions.size() == forms.size()) return std::nullopt;
        const Interval s = first->enclosure();
        const IntervalPoint p = line.at(s);
        transitions.push_back({current, next, {p[0].mid(), p[1].mid()}, reach(p[0], p[1]), {}});
        const double place = transitions.back().point[line.by_x ? 0 : 1], error = transitions.back().error;
        if (!(place - error > after && place + error < s1)) return std::nullopt;
        after = place + error;
        current = next;
    }
    decisions_.by_multiprecision += std::max<std::size_t>(transitions.size(), 1);
    return transitions;
}

// One point of a stretch of a side in which all of the forms tie. Any two of them differ by D = D' (s - p)
// or, where the derivatives agree in p too, D'' (s - p)^2 / 2, D' and D'' somewhere on the stretch: if these
// keep their signs, so does D on both sides of p.
std::optional<RimTransition> SideCrossings::find_tie(const SideLine& line, double s0, FormId l0, double s1,
                                                     FormId l1, std::span<const FormId> forms) {
    const std::size_t n = forms.size();
    if (!rule_.spares(forms) && n != 2) return std::nullopt;
    const bool shows_greater = n == 2 && rule_.shows_greater(forms[0], forms[1]);
    const double m = Interval(s0, s1).mid();
    const IntervalPoint range = line.at(Interval(s0, s1));
    const auto slope = [&](std::size_t i, std::size_t j) {
        return line.slope_difference(heights_, forms[i], forms[j], Interval(s0, s1));
    };
    const auto bend = [&](std::size_t i, std::size_t j) {
        return line.bend(heights_.curvature_difference(forms[i], forms[j], range[0], range[1]));
    };
    std::size_t a = 0, b = 1;
    bool touching = false;
    for (std::size_t i = 0; i < n && !touching; ++i)
        for (std::size_t j = i + 1; j < n && !touching; ++j) {
            touching = !slope(i, j).sign();
            if (touching) std::tie(a, b) = std::pair(i, j);
        }
    // A zero of D, or of D', of this pair: in doubles first, as few stretches hold a tie.
    const double inverse = 1 / (touching ? bend(a, b) : slope(a, b)).mid();
    if (!std::isfinite(inverse)) return std::nullopt;
    double near = m;
    for (int i = 0; i < 8; ++i) {
        const IntervalPoint at = line.at(Interval(near));
        const HeightJet<Interval> f = heights_.jet(forms[a], at[0], at[1]),
                                  g = heights_.jet(forms[b], at[0], at[1]);
        near =
            std::clamp(near - inverse * (touching ? line.along(f) - line.along(g) : f.v - g.v).mid(), s0, s1);
    }
    const IntervalPoint about = line.at(Interval(near));
    if (possibly_lowest(forms, [&](FormId f) { return heights_.value(f, about[0], about[1]); }).size() < n)
        return std::nullopt;
    constexpr int most_steps = 20;
    const auto zero = approach<Wide, 1>(of_one_unknown(
                                            [&](const Wide& at) {
                                                const auto f = line.sharp_jet(heights_, forms[a], at),
                                                           g = line.sharp_jet(heights_, forms[b], at);
                                                return touching ? f[1] - g[1] : f[0] - g[0];
                                            },
                                            1 / inverse),
                                        {Wide(near)}, {Interval::whole()},
                                        std::ldexp(extent_, assumed_exponent - 40), most_steps);
    if (!zero) return std::nullopt;
    Wide p = zero->point[0];
    const double s = nearest_double(p, extent_);
    if (s < s0 || s > s1) return std::nullopt;

    RimTransition tie{{}, {}, {}, 0, {forms.begin(), forms.end()}};
    const auto wide = line.wide_at(p);
    auto exact = points_.exact_tie(forms, wide[0], wide[1]);
    if (exact && !is_on_line(*exact, line.side.a, line.side.b, line.side.c)) exact.reset();
    if (exact) p = enclosure_of<Wide>(line.by_x ? exact->x : exact->y) / enclosure_of<Wide>(exact->w);
    bool decided = exact.has_value();
    std::vector<std::array<Wide, 2>> jets;
    for (const FormId f : forms) jets.push_back(line.sharp_jet(heights_, f, p));
    std::vector<bool> lowest_before(n, true), lowest_after(n, true);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            if (!exact && !agree(jets[i][0], jets[j][0], jets[i][0])) return std::nullopt;
            auto after = slope(i, j).sign(), before = after ? std::optional(-*after) : after;
            if (!after) {
                if (!agree(jets[i][1], jets[j][1], Wide(1.0))) return std::nullopt;
                decided = decided && have_equal_slopes(heights_.family(), forms[i], forms[j], *exact,
                                                       line.side.a, line.side.b);
                before = after = bend(i, j).sign();
            }
            if (!after || *after == Sign::Zero) return std::nullopt;
            const Sign of_hidden = shows_greater ? Sign::Positive : Sign::Negative;
            lowest_before[*before == of_hidden ? j : i] = false;
            lowest_after[*after == of_hidden ? j : i] = false;
        }
    tie.before = forms[std::ranges::find(lowest_before, true) - lowest_before.begin()];
    tie.after = forms[std::ranges::find(lowest_after, true) - lowest_after.begin()];
    if (s == s0) tie.before = tie.after;  // a corner
    if (s == s1) tie.after = tie.before;
    if (tie.before != l0 || tie.after != l1) return std::nullopt;
    const IntervalPoint place = exact ? enclosure(*exact) : line.at(p.enclosure());
    tie.point = {place[0].mid(), place[1].mid()};
    tie.error = reach(place[0], place[1]);
    // Any two have a difference, or where they touch a slope of it, that is zero once on the stretch: so what
    // the equations leave is that place.
    const auto is_tie_in_space = [&] {
        const FormFamily& family = heights_.family();
        const SpaceTie::ChartLine side{line.side.a, line.side.b, line.side.c};
        if (!SpaceTie::can_see(family, side)) return false;
        const SpaceTie in_space(family, forms, side);
        std::vector<SpacePoint> candidates = in_space.points();
        if (candidates.empty()) candidates = in_space.tangencies();
        return std::ranges::any_of(candidates, [&](const SpacePoint& x) {
            const auto at = chart_point(family, x);
            if (!at || !all_.is_met(forms[0], (*at)[0], (*at)[1])) return false;
            const Interval s_at = (*at)[line.by_x ? 0 : 1];
            if (!(s_at.lower() >= s0 && s_at.upper() <= s1)) return false;
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = i + 1; j < n; ++j)
                    if (!slope(i, j).sign() && !have_equal_slopes(family, forms[i], forms[j], x, side))
                        return false;
            return true;
        });
    };
    // One root of two forms with a slope needs no assumption.
    if (!decided && (touching || n > 2) && !is_tie_in_space())
        all_.assume(tie.point, std::ldexp(extent_, touching ? assumed_exponent / 2 : assumed_exponent),
                    tie.ties);
    return tie;
}

}  // namespace vcell
