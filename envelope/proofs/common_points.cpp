#include "common_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mixed_systems.hpp"
#include "mixed_work.hpp"
#include "space_tie.hpp"

namespace vcell {

// The point where three forms are equal, within 2^exponent of the chart's size. The Jacobian is that of
// differences with many digits: of forms that are nearly one function along a line doubles keep little of it.
std::optional<std::array<Wide, 2>> CommonPoints::sharp_vertex(const MixedPiece::Vertex& v,
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
bool CommonPoints::settle_sharply(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms) {
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
std::optional<RationalPoint> CommonPoints::exact_tie(std::span<const FormId> forms, const Wide& x,
                                                     const Wide& y) {
    auto p = rational_near(x, y, extent_);
    if (!p) return std::nullopt;
    decisions_.by_exact += forms.size() - 1;
    return all_tie(heights_.family(), forms, *p) ? std::move(p) : std::nullopt;
}

// The point in space with such coordinates over that place, if all of the forms tie there. Over a plane the
// place has them itself.
std::optional<SpacePoint> CommonPoints::exact_tie_in_space(std::span<const FormId> forms,
                                                           const std::array<Wide, 2>& at) const {
    const FormFamily& family = heights_.family();
    if (family.tips.any()) return std::nullopt;
    const auto& [x, y] = at;
    const auto X = space_quadrics::point_over(family, x, y, heights_.value(forms[0], x, y));
    auto p = X ? space_point_near(*X, extent_) : std::nullopt;
    return p && is_tie_at(family, forms, *p) ? std::move(p) : std::nullopt;
}

// The place about which forms tie as far as digits tell, if they do so exactly and three of them touch there.
// On the one trisector in the box and its surroundings the third one's height above it bends one way, so that
// there is one such place at most.
std::optional<IntervalPoint> CommonPoints::exact_touch(std::span<const FormId> touching,
                                                       std::span<const FormId> ties,
                                                       const std::array<Wide, 2>& at,
                                                       const std::array<double, 4>& box) {
    const FormFamily& family = heights_.family();
    if (const auto p = exact_tie(ties, at[0], at[1]); p && have_gradients_in_line(family, touching, *p))
        return enclosure(*p);
    const double near = 0.25 * std::min(box[1] - box[0], box[3] - box[2]);
    decisions_.by_exact += ties.size() - 1;
    std::vector<SpacePoint> candidates = SpaceTie(family, touching).tangencies();
    if (candidates.empty())
        if (auto p = exact_tie_in_space(ties, at); p && have_gradients_in_line(family, touching, *p))
            candidates.push_back(*std::move(p));
    for (const SpacePoint& p : candidates) {
        const auto place = chart_point(family, p);
        if (!place) continue;
        const auto& [x, y] = *place;
        const double off = std::max((x - at[0].enclosure()).magnitude(), (y - at[1].enclosure()).magnitude());
        const auto is_tied = [&](FormId f) { return passes_through(family, f, p); };
        if (off < near && all_.is_met(touching[0], x, y) && std::ranges::all_of(ties, is_tied)) return place;
    }
    return std::nullopt;
}

// Do all forms that tie in a vertex as far as digits tell do so exactly? In a rational point, and as there is
// only one point in which three of them do, it is the vertex then; or wherever three of them do; or in the
// point that all equations leave.
bool CommonPoints::settle_tie(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms) {
    const auto box = sharp_vertex(v, forms);
    if (!box) return false;
    if (const auto p = exact_tie(v.ties, (*box)[0], (*box)[1])) {
        const auto [x, y] = enclosure(*p);
        v.point = {x.mid(), y.mid()};
        v.error = reach(x, y);
        return true;
    }
    const Interval x = (*box)[0].enclosure(), y = (*box)[1].enclosure();
    if (!all_.is_met(forms[0], x, y)) return false;
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
        !std::ranges::any_of(SpaceTie(family, v.ties).points(), is_vertex) &&
        !exact_tie_in_space(v.ties, {(*box)[0], (*box)[1]}))
        return false;
    v.point = {x.mid(), y.mid()};
    v.error = reach(x, y);
    return true;
}

// other - forms at their common point; Zero where 200 bits do not tell them apart.
std::optional<Sign> CommonPoints::sign_at_vertex(const MixedPiece::Vertex& v, std::array<FormId, 3> forms,
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

// By how much another form is off at the common point of three, if that is no more than a scene's rounding.
std::optional<double> CommonPoints::ties_in_noise(const MixedPiece::Vertex& v,
                                                  const std::array<FormId, 3>& forms, FormId other) {
    const auto at = sharp_vertex(v, forms);
    if (!at) return std::nullopt;
    const Wide height = heights_.value(forms[0], (*at)[0], (*at)[1]);
    const Wide difference = heights_.value(other, (*at)[0], (*at)[1]) - height;
    if (difference.magnitude_exponent() >= height.magnitude_exponent() + noise_exponent) return std::nullopt;
    return difference.enclosure().magnitude();
}

// Where grad f = grad g, with many digits.
std::optional<std::array<Wide, 2>> CommonPoints::sharp_critical_point(FormId f, FormId g,
                                                                      const Vector2d& start) const {
    const auto gradients =
        model_of<Wide>([&](const WideBox<2>& p) { return equal_gradients(heights_, f, g, p); });
    constexpr int most_steps = 20;
    const auto near = approach<Wide, 2>(gradients, {Wide(start.x()), Wide(start.y())}, everywhere,
                                        std::ldexp(extent_, assumed_exponent - 40), most_steps);
    return near ? std::optional(near->point) : std::nullopt;
}

}  // namespace vcell
