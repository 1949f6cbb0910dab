// The vertices of a piece: where three forms are equal, and what else is equal there.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mixed_work.hpp"
#include "space_tie.hpp"

namespace vcell {

// Contracts a box a little larger than the piece, or the part of it where all three meet, to the root, if
// there is one.
MixedAnalysis::Inside MixedAnalysis::find_vertex(const Work& work, std::array<FormId, 3> forms,
                                                 MixedPiece::Vertex& out) {
    if (work.known_apart(forms)) return Inside::No;
    std::array<double, 4> box = work.piece.box;
    const bool by_supports = work.supports && work.rivals.size() <= most_divided;
    if (by_supports) {
        const auto place = [&](FormId f) { return work.place(*work.find(f)); };
        const auto part = work.divided().meeting(place(forms[0]), place(forms[1]), place(forms[2]));
        if (!part) return Inside::No;
        box = *part;
    }
    const Spread &a = *work.find(forms[0]), &b = *work.find(forms[1]), &c = *work.find(forms[2]);
    if (!by_supports && a.bend && b.bend && c.bend) {
        const auto offsets = heights_.are_twins(b.form, c.form)
                                 ? common_zeros(work.difference(c, b), work.difference(a, b))
                                 : common_zeros(work.difference(b, a), work.difference(c, a));
        if (!offsets) return Inside::No;
        for (const int i : {0, 1}) {
            const Interval part = Interval(work.middle()[i]) + (*offsets)[i];
            box[2 * i] = std::max(box[2 * i], part.lower());
            box[2 * i + 1] = std::min(box[2 * i + 1], part.upper());
        }
    }
    const auto system = model_of<Interval>([&](const IntervalBox<2>& p) {
        return by_supports ? equal_heights(*work.supports, forms, p) : equal_heights(heights_, forms, p);
    });
    const double dx = 0.25 * (box[1] - box[0]), dy = 0.25 * (box[3] - box[2]);
    const auto found = contract<Interval, 2>(
        system, {Interval(box[0] - dx, box[1] + dx), Interval(box[2] - dy, box[3] + dy)});
    if (found.empty) return Inside::No;
    IntervalBox<2> root = found.box;
    // Exactly one: so it is what is proved more closely in a part of the box.
    if (found.unique)
        if (const auto closer = prove_near<Interval, 2>(
                system, {Interval(root[0].mid()), Interval(root[1].mid())}, everywhere);
            closer && is_subset(*closer, root))
            root = *closer;
    const auto [X, Y] = root;
    const Inside inside = work.where(X, Y);
    if (inside == Inside::No) return inside;
    if (inside == Inside::Unknown || !found.unique) return Inside::Unknown;
    const MixedPiece::Vertex rough{{X.mid(), Y.mid()}, reach(X, Y), forms[0], {}};
    out = rough;
    const bool is_sharp =
        !is_well_known(rough.point, rough.error, forms, work.extent) && settle_sharply(out, forms) &&
        is_subset<Interval, 2>(
            {Interval::ball(out.point.x(), out.error), Interval::ball(out.point.y(), out.error)}, root);
    if (!is_sharp) out = rough;
    ++(is_sharp ? decisions_.by_multiprecision : decisions_.by_interval);
    return Inside::Yes;
}

// The point where three forms are equal, within 2^exponent of the chart's size. The Jacobian is that of
// differences with many digits: of forms that are nearly one function along a line doubles keep little of it.
std::optional<std::array<Wide, 2>> MixedAnalysis::sharp_vertex(const MixedPiece::Vertex& v,
                                                               const std::array<FormId, 3>& forms,
                                                               int exponent) {
    const auto linearise = [&](const WideBox<2>& p) { return equal_heights(heights_, forms, p); };
    const double radius = std::ldexp(extent_, exponent);
    constexpr int most_steps = 20;
    const auto near = approach<Wide, 2>(model_of<Wide>(linearise), {Wide(v.point.x()), Wide(v.point.y())},
                                        everywhere, 0.25 * radius, most_steps);
    if (!near) return std::nullopt;
    const Wide d(-radius, radius);
    const WideBox<2> box{near->point[0] + d, near->point[1] + d};
    LocalModel<Wide, 2> local = linearise(box);
    local.value = near->local.value;
    if (!krawczyk_step<Wide, 2>(local, Offsets<Wide, 2>(near->point, d), box, Preconditioning::Inverse)
             .unique())
        return std::nullopt;
    return box;
}

// Takes a vertex to where three forms are equal, as near as doubles go.
bool MixedAnalysis::settle_sharply(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms) {
    // Twice the digits of a double: each step more costs as much as everything else about a vertex.
    constexpr int exponent = -100;
    const auto sharp = sharp_vertex(v, forms, exponent);
    if (!sharp) return false;
    v.point = {(*sharp)[0].approximation(), (*sharp)[1].approximation()};
    v.error = Interval::up(4 * std::numeric_limits<double>::epsilon() * v.point.norm() +
                           std::ldexp(extent_, exponent + 1) + std::numeric_limits<double>::min());
    return true;
}

// The point with rational coordinates that these stand for, if all of the forms tie there.
std::optional<RationalPoint> MixedAnalysis::exact_tie(std::span<const FormId> forms, const Wide& x,
                                                      const Wide& y) {
    auto p = rational_near(x, y, extent_);
    if (!p || (!heights_.family().radial.empty() && p->w != Exact(1.0))) return std::nullopt;
    decisions_.by_exact += forms.size() - 1;
    return all_tie(heights_.family(), forms, *p) ? std::move(p) : std::nullopt;
}

// Is a form's height certainly one that its equation has?
bool MixedAnalysis::is_met(FormId f, const Interval& x, const Interval& y) const {
    return heights_.value(f, x, y).sign() == heights_.family().compared_over().sign_of_met();
}

// The place about which forms tie as far as digits tell, if they do so exactly and three of them touch there.
// On the one trisector in the box and its surroundings the third one's height above it bends one way, so that
// there is one such place at most.
std::optional<IntervalPoint> MixedAnalysis::exact_touch(std::span<const FormId> touching,
                                                        std::span<const FormId> ties,
                                                        const std::array<Wide, 2>& at,
                                                        const std::array<double, 4>& box) {
    const FormFamily& family = heights_.family();
    if (const auto p = exact_tie(ties, at[0], at[1]); p && have_gradients_in_line(family, touching, *p))
        return enclosure(*p);
    const double near = 0.25 * std::min(box[1] - box[0], box[3] - box[2]);
    decisions_.by_exact += ties.size() - 1;
    for (const SpacePoint& p : SpaceTie(family, touching).tangencies()) {
        const auto place = chart_point(family, p);
        if (!place) continue;
        const auto& [x, y] = *place;
        const double off = std::max((x - at[0].enclosure()).magnitude(), (y - at[1].enclosure()).magnitude());
        const auto is_tied = [&](FormId f) { return passes_through(family, f, p); };
        if (off < near && is_met(touching[0], x, y) && std::ranges::all_of(ties, is_tied)) return place;
    }
    return std::nullopt;
}

// Do all forms that tie in a vertex as far as digits tell do so exactly? In a rational point, and as there is
// only one point in which three of them do, it is the vertex then; or wherever three of them do; or in the
// point that all equations leave.
bool MixedAnalysis::settle_tie(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms) {
    const auto box = sharp_vertex(v, forms);
    if (!box) return false;
    if (const auto p = exact_tie(v.ties, (*box)[0], (*box)[1])) {
        const auto [x, y] = enclosure(*p);
        v.point = {x.mid(), y.mid()};
        v.error = reach(x, y);
        return true;
    }
    const Interval x = (*box)[0].enclosure(), y = (*box)[1].enclosure();
    if (!is_met(forms[0], x, y)) return false;
    const FormFamily& family = heights_.family();
    const SpaceTie tie(family, forms);
    const auto is_theirs = [&](FormId f) {
        return std::ranges::find(forms, f) != forms.end() || tie.implies(f);
    };
    const auto is_vertex = [&](const SpacePoint& p) {
        const auto at = wide_chart_point(family, p);
        return at && (*box)[0].contains((*at)[0]) && (*box)[1].contains((*at)[1]);
    };
    if (!std::ranges::all_of(v.ties, is_theirs) &&
        !std::ranges::any_of(SpaceTie(family, v.ties).points(), is_vertex))
        return false;
    v.point = {x.mid(), y.mid()};
    v.error = reach(x, y);
    return true;
}

// other - forms at their common point; Zero where 200 bits do not tell them apart.
std::optional<Sign> MixedAnalysis::sign_at_vertex(const MixedPiece::Vertex& v, std::array<FormId, 3> forms,
                                                  FormId other) {
    const Interval X = Interval::ball(v.point.x(), v.error), Y = Interval::ball(v.point.y(), v.error);
    if (const auto s = heights_.value_difference(other, forms[0], X, Y).sign()) {
        ++decisions_.by_interval;
        return s;
    }
    const auto box = sharp_vertex(v, forms);
    if (!box) return std::nullopt;
    const Wide height = heights_.value(forms[0], (*box)[0], (*box)[1]);
    const Wide difference = heights_.value(other, (*box)[0], (*box)[1]) - height;
    ++decisions_.by_multiprecision;
    if (const auto s = difference.sign()) return s;
    if (difference.magnitude_exponent() < height.magnitude_exponent() + assumed_exponent) return Sign::Zero;
    return std::nullopt;
}

// Chooses three rivals that are certainly equal in no more than one point of the piece.
std::optional<std::array<FormId, 3>> MixedAnalysis::triple_in_one_point(const Work& work) {
    const std::vector<Spread>& r = work.rivals;
    for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = i + 1; j < r.size(); ++j)
            for (std::size_t k = j + 1; k < r.size(); ++k)
                if (const auto turn = work.turn(r[i], r[j], r[k]); turn && *turn != Sign::Zero)
                    return std::array{r[i].form, r[j].form, r[k].form};
    return std::nullopt;
}

// All gradients are on one line: the apex is where three of the forms touch.
std::optional<MixedAnalysis::Apex> MixedAnalysis::find_apex_in_line(const Work& work, Apex apex) {
    const std::vector<Spread>& r = work.rivals;
    const auto touching = [&]() -> std::optional<Touching> {
        for (const std::size_t m : {0u, 1u, 2u})
            for (const auto find : {find_touching, find_pinch})
                if (auto t =
                        find(heights_, r[m].form, r[(m + 1) % 3].form, r[(m + 2) % 3].form, work.piece.box))
                    return t;
        return std::nullopt;
    }();
    if (!touching) return std::nullopt;
    apex.point = touching->place;
    apex.error = touching->width;
    if (work.where(apex.point, apex.error) != Inside::Yes) return std::nullopt;
    const auto& [x, y] = touching->at;
    for (const Spread& s : r)
        if (!agree(heights_.value(s.form, x, y), touching->height, touching->height)) return std::nullopt;
    apex.decided = true;
    find_between(work, apex, assumed_exponent);
    return apex;
}

// The triples of the apex whose gradients are on one line there: where two of them are equal, the third one's
// height above them is 0 at the apex, as its slope is, and bends one way. Or it is so up to noise, in some
// place nearby, which is the apex's noise.
void MixedAnalysis::find_between(const Work& work, Apex& apex, int exponent) {
    const std::vector<Spread>& r = work.rivals;
    const auto add = [&](std::size_t m, std::size_t i, std::size_t j) {
        const FormId h = r[m].form, f = r[i].form, g = r[j].form;
        for (const bool shows : {false, true}) {
            const auto touching = (shows ? find_pinch : find_touching)(heights_, h, f, g, work.piece.box);
            if (!touching ||
                touching->gap.magnitude_exponent() >= touching->height.magnitude_exponent() + exponent)
                continue;
            const double apart = (touching->place - apex.point).norm();
            if (exponent == assumed_exponent) {
                if (apart > touching->width + 2 * apex.error) continue;
                apex.decided = apex.decided &&
                               exact_touch(std::array{f, g, h}, work.forms(), touching->at, work.piece.box);
            } else {
                apex.noise = std::max(apex.noise, Interval::up(apart + touching->width));
            }
            ++decisions_.by_multiprecision;
            apex.between.push_back({m, {i, j}, shows});
            return true;
        }
        return false;
    };
    for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = i + 1; j < r.size(); ++j)
            for (std::size_t k = j + 1; k < r.size(); ++k)
                if (!work.turn(r[i], r[j], r[k])) add(i, j, k) || add(j, i, k) || add(k, i, j);
}

// By how much another form is off at the common point of three, if that is no more than a scene's rounding.
std::optional<double> MixedAnalysis::ties_in_noise(const MixedPiece::Vertex& v,
                                                   const std::array<FormId, 3>& forms, FormId other) {
    const auto at = sharp_vertex(v, forms);
    if (!at) return std::nullopt;
    const Wide height = heights_.value(forms[0], (*at)[0], (*at)[1]);
    const Wide difference = heights_.value(other, (*at)[0], (*at)[1]) - height;
    if (difference.magnitude_exponent() >= height.magnitude_exponent() + noise_exponent) return std::nullopt;
    return difference.enclosure().magnitude();
}

}  // namespace vcell
