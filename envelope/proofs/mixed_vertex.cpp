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

// The place about which three forms tie as far as digits tell, if they do so exactly and touch there. On the
// one trisector in the box and its surroundings the third one's height above it bends one way, so that there
// is one such place at most.
std::optional<IntervalPoint> MixedAnalysis::exact_touch(std::span<const FormId> forms, bool is_tie,
                                                        const std::array<Wide, 2>& at,
                                                        const std::array<double, 4>& box) {
    if (!is_tie) return std::nullopt;
    if (const auto p = exact_tie(forms, at[0], at[1]);
        p && have_gradients_in_line(heights_.family(), forms, *p))
        return enclosure(*p);
    const double near = 0.25 * std::min(box[1] - box[0], box[3] - box[2]);
    decisions_.by_exact += forms.size() - 1;
    for (const SpacePoint& p : SpaceTie(heights_.family(), forms).tangencies()) {
        const auto place = chart_point(heights_.family(), p);
        if (!place) continue;
        const auto& [x, y] = *place;
        const double off = std::max((x - at[0].enclosure()).magnitude(), (y - at[1].enclosure()).magnitude());
        if (off < near && is_met(forms[0], x, y)) return place;
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

}  // namespace vcell
