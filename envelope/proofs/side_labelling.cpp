#include "side_labelling.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/errors.hpp"
#include "../../primitives/forms/exact_heights.hpp"
#include "mixed_terms.hpp"

namespace vcell {

namespace {

// Where two lines meet, by Cramer's rule: (x, y) times w, and w.
template <class T>
std::array<T, 3> crossing(const PieceSide& s, const PieceSide& t) {
    return {T(s.b) * T(t.c) - T(t.b) * T(s.c), T(s.c) * T(t.a) - T(t.c) * T(s.a),
            T(s.a) * T(t.b) - T(s.b) * T(t.a)};
}

}  // namespace

IntervalPoint corner_of(const PieceSide& s, const PieceSide& t) {
    if (axis_parallel(s) && axis_parallel(t)) {  // exact
        const PieceSide &upright = s.b == 0 ? s : t, &level = s.b == 0 ? t : s;
        return {Interval(-upright.c * upright.a), Interval(-level.c * level.b)};
    }
    const auto [x, y, w] = crossing<Interval>(s, t);
    return {x / w, y / w};
}

SideLabels SideLabels::reversed() const {
    SideLabels out{last(), {}};
    for (auto t = transitions.rbegin(); t != transitions.rend(); ++t) {
        out.transitions.push_back(*t);
        std::swap(out.transitions.back().before, out.transitions.back().after);
    }
    return out;
}

namespace {

// Those of the candidates that attain the minimum at a point: with 320 bits, exactly where these leave
// several.
std::vector<FormId> lowest_in_many_digits(const Heights& heights, const RationalPoint& p,
                                          std::span<const FormId> candidates, Decisions& decisions) {
    std::vector<Wide> values;
    const Wide w = enclosure_of<Wide>(p.w), x = enclosure_of<Wide>(p.x) / w, y = enclosure_of<Wide>(p.y) / w;
    for (const FormId f : candidates) values.push_back(heights.value(f, x, y));
    std::vector<FormId> lowest;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::ranges::none_of(values,
                                 [&](const Wide& v) { return (v - values[i]).sign() == Sign::Negative; }))
            lowest.push_back(candidates[i]);
    decisions.by_multiprecision += candidates.size() - 1;
    return lowest.size() == 1 ? lowest : exactly_lowest(lowest, [&](FormId f, FormId g) {
        return heights.compare(f, g, p, decisions);
    });
}

// Are two forms one function along the line? Over a plane a height's reciprocal q is the positive root of
// c q^2 - 2 b q - a, c > 0, a >= 0, where c is of degree two at most along the line, b of degree one, and a a
// constant: the resultant of two of them is of degree four. If the heights are equal in five places it is
// zero all along, and there is a root that both have. That does not vanish unless both a do; then without the
// roots q = 0 what is left is linear in q, and the resultant of degree three. So the root that is positive in
// these places is so between them, and is the height.
bool are_one_from(const FormFamily& family, const SideLine& line, double s0, double s1, FormId f, FormId g,
                  Decisions& decisions) {
    constexpr int places = 5;
    const std::array forms{f, g};
    for (int i = 0; i < places; ++i)
        if (!all_tie(family, forms, line.exact_at(s0 + (i + 0.5) / places * (s1 - s0)))) return false;
    ++decisions.by_exact;
    return true;
}

}  // namespace

bool are_one_along(const FormFamily& family, const PieceSide& side, const Eigen::Vector2d& from,
                   const Eigen::Vector2d& to, FormId f, FormId g, Decisions& decisions) {
    const SideLine line(side);
    const int along = line.by_x ? 0 : 1;
    return are_one_from(family, line, from[along], to[along], f, g, decisions);
}

template <class Exactly>
SideLabelling::Lowest SideLabelling::lowest_at(const IntervalPoint& p, std::span<const FormId> candidates,
                                               Exactly&& exactly) {
    const std::vector<FormId> open = all_.not_hidden(candidates, p[0], p[1]);
    if (!heights_.family().hidden.empty()) candidates = open;
    if (const auto f = all_.certainly_lowest(p, candidates)) {
        ++decisions_.by_double;
        return {*f};
    }
    const auto value = [&](FormId f) { return heights_.value(f, p[0], p[1]); };
    const bool is_exact = is_point(p[0]) && is_point(p[1]);
    if (rule_.is_any()) {
        std::vector<FormId> showing = rule_.possibly_showing(candidates, value);
        ++decisions_.by_interval;
        if (showing.size() > 1) {
            const RationalPoint at = is_exact ? RationalPoint{p[0].mid(), p[1].mid()} : exactly();
            showing = rule_.exactly_showing(
                showing, [&](FormId f, FormId g) { return heights_.compare(f, g, at, decisions_); });
        }
        return {showing.begin(), showing.end()};
    }
    std::vector<FormId> lowest = possibly_lowest(candidates, value);
    ++decisions_.by_interval;
    if (lowest.size() > 1)
        lowest = is_exact ? exactly_lowest(heights_, p[0].mid(), p[1].mid(), lowest, decisions_)
                          : lowest_in_many_digits(heights_, exactly(), lowest, decisions_);
    return {lowest.begin(), lowest.end()};
}

std::vector<FormId> SideLabelling::lowest_at(const PieceSide& s, const PieceSide& t,
                                             std::span<const FormId> candidates) {
    const Lowest lowest = lowest_at(corner_of(s, t), candidates, [&] {
        const auto [x, y, w] = crossing<Exact>(s, t);
        return rational(x, y, w);
    });
    return {lowest.begin(), lowest.end()};
}

SideLabelling::Lowest SideLabelling::lowest_at(const SideLine& line, double s,
                                               std::span<const FormId> candidates) {
    return lowest_at(line.at(Interval(s)), candidates, [&] { return line.exact_at(s); });
}

bool SideEffort::is_too_much(std::size_t forms) const {
    // Measured: 80 evaluations and some hundred stretches to a form are usual; a few thousand evaluations in
    // all where a tie of some ten forms is settled, 150,000 stretches along a line that hardly leaves a
    // plane.
    constexpr std::size_t most_wide = 10000, wide_of_form = 500, most_stretches = 150000,
                          stretches_of_form = 5000;
    return wide > most_wide + wide_of_form * forms || stretches > most_stretches + stretches_of_form * forms;
}

// The forms that may be lowest somewhere between s0 and s1, and if there are two the least slope of their
// difference.
SideLabelling::Rivals SideLabelling::rivals_along(const SideLine& line, double s0, double s1,
                                                  std::span<const FormId> candidates) {
    const double m = Interval(s0, s1).mid(), r = Interval(s0, s1).radius();
    const IntervalPoint middle = line.at(Interval(m)), range = line.at(Interval(s0, s1));
    Rivals out{{}, 0};
    const double extent = all_.extent_at(range[0], range[1]);
    const std::vector<FormId> open = all_.not_hidden(candidates, range[0], range[1]);
    if (!heights_.family().hidden.empty()) candidates = open;
    std::vector<FormId> left;  // where supports do not tell twins apart
    if (all_.compare_by_supports(s1 - s0, extent)) {
        const NormalBox box(range[0].lower(), range[0].upper(), range[1].lower(), range[1].upper());
        const auto rivals = all_.lowest_supports(box, candidates);
        for (const SupportRival& rival : rivals) out.forms.push_back(rival.form);
        if (!all_.have_twins(rivals)) {
            if (rivals.size() == 2) {
                const auto [gx, gy] = box.gradient(rivals[0].support, rivals[1].support);
                out.least_slope = least_magnitude(line.along({{}, gx, gy}));
            }
            return out;
        }
        left.assign(out.forms.begin(), out.forms.end());
        candidates = left;
        out.forms.clear();
    }
    struct Item {
        FormId form;
        Interval v, slope, range;
    };
    std::vector<Item> items;
    items.reserve(candidates.size());
    for (const FormId f : candidates) {
        const HeightJet<Interval> all = heights_.jet(f, range[0], range[1]);
        items.push_back({f, {}, line.along(all), all.v});
    }
    const auto form = [](const Item& i) { return i.form; };
    rule_.drop_out_of_range(items, form);
    for (Item& i : items) i.v = heights_.value(i.form, middle[0], middle[1]);
    const auto values = [&](const Item& i) {
        const double step = i.slope.magnitude() * r;
        return narrowed(i.range, {i.v.lower() - step, i.v.upper() + step});
    };
    const auto certainly_above = [&](const Item& a, const Item& b) {
        return a.range.lower() > b.range.upper() ||
               (a.v.lower() > b.v.upper() &&  // what is subtracted is not negative
                (a.v - b.v - (a.slope - b.slope).magnitude() * Interval(r)).lower() > 0) ||
               (heights_.are_twins(a.form, b.form) &&
                line.is_above_twin(heights_, a.form, b.form, Interval(s0, s1)));
    };
    rule_.drop_hidden(items, form, values, certainly_above);
    if (items.size() == 2) out.least_slope = least_magnitude(items[0].slope - items[1].slope);
    if (items.size() == 2 && out.least_slope == 0) {
        items[0].slope = line.mean_slope_difference(heights_, items[0].form, items[1].form, Interval(s0, s1));
        items[1].slope = 0;
        out.least_slope = least_magnitude(items[0].slope);
        const FormId f = items[0].form, g = items[1].form;
        const Interval difference = heights_.are_twins(f, g)
                                        ? heights_.value_difference(f, g, middle[0], middle[1])
                                        : items[0].v - items[1].v,
                       reach = Interval(items[0].slope.magnitude()) * Interval(r);
        const bool is_above = (difference - reach).lower() > 0, is_below = (difference + reach).upper() < 0,
                   shows_greater = rule_.shows_greater(items[0].form, items[1].form);
        if (shows_greater ? is_below : is_above)
            items.erase(items.begin());
        else if (is_above || is_below)
            items.pop_back();
    }
    if (items.size() > 1 && out.least_slope == 0 && s1 - s0 < sharp_width * extent) {
        struct SharpItem : Item {
            Wide height;
        };
        std::vector<SharpItem> sharp;
        for (const Item& i : items) sharp.push_back({i, line.sharp_height(heights_, i.form, m)});
        const auto sharply_above = [&](const SharpItem& a, const SharpItem& b) {
            return ((a.height - b.height).enclosure() -
                    Interval((a.slope - b.slope).magnitude()) * Interval(r))
                       .lower() > 0;
        };
        rule_.drop_hidden(
            sharp, [](const SharpItem& i) { return i.form; }, sharply_above);
        decisions_.by_multiprecision += items.size() - sharp.size();
        items.assign(sharp.begin(), sharp.end());
        if (items.size() == 2) out.least_slope = least_magnitude(items[0].slope - items[1].slope);
    }
    for (const Item& i : items) out.forms.push_back(i.form);
    return out;
}

// Stretches with more than two forms this short, as a part of the region, are asked for the order of all
// crossings.
constexpr double crowded_width = 0x1p-36;

// A seam on which forms tie is given up after so many evaluations with many digits: there are others.
constexpr std::size_t most_along_seam = 2000;

bool SideLabelling::are_one_along(const SideLine& line, double s0, double s1, FormId f, FormId g) {
    if (!heights_.family().are_quadratic() || rule_.is_any()) return false;
    return are_one_from(heights_.family(), line, s0, s1, f, g, decisions_);
}

// The forms are one function along a side of the region, from s0 to s1. This leaves out those that rise above
// others of them towards the inside all along the part from t0 to t1. Is anything left out?
template <class Forms>
bool SideLabelling::leave_lowest_inside(const SideLine& line, double s0, double s1, double t0, double t1,
                                        Forms& forms) {
    const IntervalPoint range = line.at(Interval(t0, t1));
    const auto rises_above = [&](FormId g, FormId f) {
        const HeightJet<Interval> d = heights_.difference(g, f, range[0], range[1]);
        return (line.side.a * d.gx + line.side.b * d.gy).lower() > 0;
    };
    const auto loses = [&](FormId g) {
        return std::ranges::any_of(forms, [&](FormId f) {
            return f != g && rises_above(g, f) && are_one_along(line, s0, s1, f, g);
        });
    };
    Forms left;
    for (const FormId g : forms)
        if (!loses(g)) left.push_back(g);
    const bool is_less = left.size() < forms.size();
    forms = std::move(left);
    return is_less;
}

// A form that is one function with either of those that change places ties there.
void SideLabelling::add_if_one(const SideLine& line, double s0, double s1, FormId f, RimTransition& t) {
    if (!are_one_along(line, s0, s1, f, t.before) && !are_one_along(line, s0, s1, f, t.after)) return;
    if (t.ties.empty()) t.ties = {t.before, t.after};
    t.ties.push_back(f);
}

// This leaves out what shows nowhere over a stretch but where it ties with two others, unless it is a label
// already: where the base was turned what ties may show by a rounding.
void SideLabelling::leave_out_between(const IntervalPoint& range, FormId l0, FormId l1,
                                      SmallVector<FormId, usual_rivals>& forms) {
    const std::vector<FormId> hidden =
        all_.common_curves().hidden({forms.begin(), forms.size()}, range[0], range[1]);
    const auto is_hidden = [&](FormId f) { return std::ranges::find(hidden, f) != hidden.end(); };
    if (hidden.empty() || is_hidden(l0) || is_hidden(l1)) return;
    SmallVector<FormId, usual_rivals> left;
    for (const FormId f : forms)
        if (!is_hidden(f)) left.push_back(f);
    forms = std::move(left);
}

// From s0 to s1, ascending, the lowest form changes from l0 to l1. Appends all changes.
bool SideLabelling::descend(const SideLine& line, double s0, FormId l0, double s1, FormId l1,
                            std::span<const FormId> candidates, bool is_seam,
                            std::vector<RimTransition>& out) {
    const double m = Interval(s0, s1).mid();
    const IntervalPoint middle = line.at(Interval(m)), range = line.at(Interval(s0, s1));
    const double extent = all_.extent_at(range[0], range[1]);
    ++stretches_;
    auto [left, least_slope] = rivals_along(line, s0, s1, candidates);
    if (left.size() > 2 && s1 - s0 < tie_width * all_.tie_extent_at(range[0], range[1])) {
        leave_out_between(range, l0, l1, left);
        if (left.size() == 2) {
            least_slope =
                least_magnitude(line.slope_difference(heights_, left[0], left[1], Interval(s0, s1)));
        }
    }
    decisions_.by_interval += candidates.size() - left.size();
    if (left.size() == 1) return true;
    if (least_slope > 0) {
        ++decisions_.by_interval;
        if (l0 != l1) out.push_back(roots_.locate(line, s0, s1, l0, l1, least_slope));
        return true;
    }
    // Where forms tie along a curve that crosses the side, shorter stretches tell more than one point of it.
    const auto is_curve = [&] {
        return left.size() == 3 && s1 - s0 > crowded_width * extent &&
               all_.common_curves().may_tie({left[0], left[1], left[2]}, range[0], range[1]);
    };
    if (!is_seam && s1 - s0 < sharp_width * extent && !is_curve())
        if (const auto tie = crossings_.find_tie(line, s0, l0, s1, l1, left)) {
            out.push_back(*tie);
            return true;
        }
    if (left.size() > 2 && s1 - s0 <= crowded_width * extent)
        if (const auto crossings = crossings_.order(line, s0, l0, s1, l1, left)) {
            out.insert(out.end(), crossings->begin(), crossings->end());
            return true;
        }
    if (s1 - s0 <= side_floor_width * extent || m <= s0 || m >= s1) {
        if (is_seam) {
            obstacle_ = Assumption{{middle[0].mid(), middle[1].mid()}, s1 - s0, {left.begin(), left.end()}};
            return false;
        }
        RimTransition t{l0,
                        l1,
                        {middle[0].mid(), middle[1].mid()},
                        reach(range[0], range[1]),
                        {left.begin(), left.end()}};
        all_.assume(t.point, s1 - s0, t.ties);
        out.push_back(std::move(t));
        return true;
    }
    if (is_spent() || (is_seam && heights_.wide_evaluations() - wide_before_side_ > most_along_seam)) {
        const Assumption tie{{middle[0].mid(), middle[1].mid()}, s1 - s0, {left.begin(), left.end()}};
        if (is_spent()) throw TieError(tie);
        obstacle_ = tie;
        return false;
    }
    for (const double ratio : {0.48643, 0.53171, 0.41234}) {
        const double s = s0 + ratio * (s1 - s0);
        const auto lowest = lowest_at(line, s, left);
        if (lowest.size() != 1 && ratio != 0.41234) continue;
        if (lowest.size() != 1 && !is_seam) {
            auto inside = left;
            if (leave_lowest_inside(line, s0, s1, s0, s1, inside)) {
                const std::size_t before = out.size();
                if (!descend(line, s0, l0, s1, l1, {inside.begin(), inside.end()}, is_seam, out))
                    return false;
                for (RimTransition& t : std::span(out).subspan(before))
                    for (const FormId f : left)
                        if (std::ranges::find(inside, f) == inside.end()) add_if_one(line, s0, s1, f, t);
                return true;
            }
        }
        if (lowest.size() != 1) {
            const IntervalPoint p = line.at(Interval(s));
            const Assumption tie{{p[0].mid(), p[1].mid()}, s1 - s0, {lowest.begin(), lowest.end()}};
            if (!is_seam) throw TieError(tie);
            obstacle_ = tie;
            return false;
        }
        return descend(line, s0, l0, s, lowest[0], left, is_seam, out) &&
               descend(line, s, lowest[0], s1, l1, left, is_seam, out);
    }
    throw InternalError("a side was not divided");
}

std::optional<SideLabels> SideLabelling::label_side(const PieceSide& side, const IntervalPoint& from,
                                                    const IntervalPoint& to, FormId first, FormId last,
                                                    std::vector<FormId> candidates, bool is_seam) {
    const SideLine line(side);
    const Interval p = line.coordinate(from), q = line.coordinate(to);
    const bool ascending = line.ascends();
    const double s0 = std::min(p.lower(), q.lower()), s1 = std::max(p.upper(), q.upper());
    SideLabels labels{ascending ? first : last, {}};
    wide_before_side_ = heights_.wide_evaluations();
    if (!descend(line, s0, labels.first, s1, ascending ? last : first, candidates, is_seam,
                 labels.transitions))
        return std::nullopt;
    // What ties in a corner is the corner's.
    std::erase_if(labels.transitions, [&](const RimTransition& t) {
        const double s = t.point[line.by_x ? 0 : 1];
        return t.before == t.after && (p.contains(s) || q.contains(s));
    });
    if (is_seam) {
        // Certainly between the corners, and apart from each other.
        double after = ascending ? p.upper() : q.upper();
        const double end = ascending ? q.lower() : p.lower();
        for (const RimTransition& t : labels.transitions) {
            const double s = t.point[line.by_x ? 0 : 1];
            if (s - t.error <= after || s + t.error >= end) return std::nullopt;
            after = s + t.error;
        }
    }
    return ascending ? std::move(labels) : labels.reversed();
}

FormId SideLabelling::label_beside(const PieceSide& side, const IntervalPoint& from, const IntervalPoint& to,
                                   std::span<const FormId> candidates) {
    const SideLine line(side);
    const double p = line.coordinate(from).mid(), q = line.coordinate(to).mid();
    for (double part = side_floor_width; part < 1; part *= 16) {
        const double s = p + part * (q - p);
        auto lowest = lowest_at(line, s, candidates);
        if (lowest.size() > 1) leave_lowest_inside(line, p, q, s, s, lowest);
        if (lowest.size() == 1) return lowest[0];
    }
    throw TieError({{from[0].mid(), from[1].mid()}, std::abs(q - p), {candidates.begin(), candidates.end()}});
}

}  // namespace vcell
