#include "given_tie.hpp"

#include <algorithm>

namespace vcell {

GivenTie::GivenTie(Competition& all, PieceWork& work, const NoisyTie& tie)
    : PieceArgument(all, work), tie_(tie) {
    const FormFamily& family = heights_.family();
    if (!family.given) return;
    for (const FormId f : tie_.forms)
        if (auto equation = family.given->of(f)) given_.push_back({f, *std::move(equation)});
}

bool GivenTie::is_exact(const std::optional<std::array<FormId, 3>>& three) const {
    const FormFamily& family = heights_.family();
    if (given_.size() < tie_.forms.size()) return false;
    if (three && tie_.touching.empty() && tie_.in_line.empty() && follow_from(*three)) return true;
    std::vector<Quadric> all{family.given->base};
    for (const Given& g : given_) all.push_back(g.equation);
    const SpaceTie in_space(family, std::move(all));
    std::vector<SpacePoint> candidates = in_space.points();
    if (candidates.empty()) candidates = in_space.tangencies();
    return std::ranges::any_of(candidates, [&](const SpacePoint& p) { return is_at(p) && touch_at(p); });
}

const GivenTie::Quadric& GivenTie::equation(FormId f) const {
    return std::ranges::find(given_, f, &Given::form)->equation;
}

// Then all tie wherever three of them do: in one point of the piece, as near to where the forms do as these
// are to what was given.
bool GivenTie::follow_from(const std::array<FormId, 3>& three) const {
    const FormFamily& family = heights_.family();
    const SpaceTie in_space(family,
                            {family.given->base, equation(three[0]), equation(three[1]), equation(three[2])});
    return std::ranges::all_of(given_, [&](const Given& g) {
        if (std::ranges::find(three, g.form) != three.end()) return true;
        const auto implied = in_space.implied(g.equation);
        return implied && !implied->beside;
    });
}

// Is the point over the piece, next to that place? The tangent of half an angle and lengths along the axis
// change by no more than the way over the distance from the axis, and in the family's unit.
bool GivenTie::is_at(const SpacePoint& p) const {
    const FormFamily& family = heights_.family();
    const Interval x = Interval::ball(tie_.point.x(), tie_.error),
                   y = Interval::ball(tie_.point.y(), tie_.error);
    const FormId f = tie_.forms[0];
    const Interval height = family.tips.any() ? heights_.plain_jet(f, x, y).v : heights_.jet(f, x, y).v;
    if (height.sign() != family.compared_over().sign_of_met()) return false;
    const auto there = space_quadrics::places(family, x, y, height), X = enclosure(p);
    double off = 0;
    for (std::size_t k = 0; k < 4; ++k) off = std::max(off, (X[k] - there[k]).magnitude());
    const double most = std::max(height.magnitude(), 1 / family.axial_unit);
    return work_.where(tie_.point, tie_.error + 4 * off * most) == Inside::Yes;
}

bool GivenTie::touch_at(const SpacePoint& p) const {
    const Quadric& base = heights_.family().given->base;
    return std::ranges::all_of(tie_.touching,
                               [&](const auto& f) {
                                   return have_equal_gradients({base, equation(f[0]), equation(f[1])}, p);
                               }) &&
           std::ranges::all_of(tie_.in_line, [&](const auto& f) {
               return have_gradients_in_line({base, equation(f[0]), equation(f[1]), equation(f[2])}, p);
           });
}

}  // namespace vcell
