// Which forms compete in a piece, and how it is best divided.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mixed_work.hpp"

namespace vcell {

MixedAnalysis::MixedAnalysis(const FormFamily& family, double extent, const EnvelopeOptions& options)
    : heights_(family), rule_(family, options), extent_(extent) {
    if (family.compared_over().is_sphere()) supports_.emplace(family);
}

bool MixedAnalysis::is_spent() const {
    // Measured: 80 evaluations and some hundred stretches to a form are usual; a few thousand evaluations in
    // all where a tie of some ten forms is settled, 150,000 stretches along a line that hardly leaves a
    // plane.
    constexpr std::size_t most_wide = 10000, wide_of_form = 500, most_stretches = 150000,
                          stretches_of_form = 5000;
    const std::size_t forms = heights_.family().size();
    return heights_.wide_evaluations() > most_wide + wide_of_form * forms ||
           stretches_ > most_stretches + stretches_of_form * forms;
}

// A point of the rim may be met from its side and from inside: it is listed once.
void MixedAnalysis::assume(const Vector2d& place, double width, std::vector<FormId> forms) {
    std::ranges::sort(forms);
    for (Assumption& known : assumptions_) {
        const double same = known.width + width + 4 * std::numeric_limits<double>::epsilon() * place.norm();
        if (known.forms != forms || (known.place - place).norm() > same) continue;
        known.width = std::max(known.width, width);
        return;
    }
    ++decisions_.assumed;
    assumptions_.push_back({place, width, std::move(forms)});
}

void MixedAnalysis::bend(const std::array<double, 4>& box, std::vector<Spread>& rivals) const {
    const Interval X(box[0], box[1]), Y(box[2], box[3]), mx(X.mid()), my(Y.mid());
    for (Spread& s : rivals)
        s.bend = {heights_.jet(s.form, mx, my), heights_.curvature(s.form, X, Y), X - mx, Y - my};
}

// The gradient of a - b over the box, of which `over` is known, made narrower by second derivatives. Pre:
// both are bent.
std::array<Interval, 2> MixedAnalysis::bent_gradient(const std::array<Interval, 2>& over, const Spread& a,
                                                     const Spread& b) {
    const auto &p = *a.bend, &q = *b.bend;
    return refined_gradient(over, {p.middle.gx - q.middle.gx, p.middle.gy - q.middle.gy},
                            p.curvature - q.curvature, p.dx, p.dy);
}

// Does the first of two twins lie above the other all over the box?
bool MixedAnalysis::is_above_twin(FormId f, FormId g, const Interval& X, const Interval& Y) const {
    const auto over = *heights_.twin_difference(f, g, X, Y);
    if (over.v.lower() > 0) return true;
    const Interval middle = heights_.twin_difference(f, g, X.mid(), Y.mid())->v;
    return (middle - over.x.magnitude() * Interval(X.radius()) - over.y.magnitude() * Interval(Y.radius()))
               .lower() > 0;
}

std::vector<MixedAnalysis::Spread> MixedAnalysis::lowest_spreads(const std::array<double, 4>& box,
                                                                 std::span<const FormId> candidates) const {
    const Interval X(box[0], box[1]), Y(box[2], box[3]), mx(X.mid()), my(Y.mid());
    const double rx = X.radius(), ry = Y.radius();
    std::vector<Spread> spreads;
    spreads.reserve(candidates.size());
    for (const FormId f : candidates) {
        const HeightJet<Interval> all = heights_.jet(f, X, Y);
        spreads.push_back({f, {}, {}, all.gx, all.gy, all.v, {}});
    }
    const auto form = [](const Spread& s) { return s.form; };
    rule_.drop_out_of_range(spreads, form);
    for (Spread& s : spreads) s.v = heights_.value(s.form, mx, my);
    const auto certainly_above = [&](const Spread& a, const Spread& b) {
        return a.range.lower() > b.range.upper() ||
               (a.v - b.v - (a.gx - b.gx).magnitude() * Interval(rx) -
                (a.gy - b.gy).magnitude() * Interval(ry))
                       .lower() > 0 ||
               (heights_.are_twins(a.form, b.form) && is_above_twin(a.form, b.form, X, Y));
    };
    const auto values = [&](const Spread& s) {
        const double step = s.gx.magnitude() * rx + s.gy.magnitude() * ry;
        return narrowed(s.range, {s.v.lower() - step, s.v.upper() + step});
    };
    const auto drop = [&](std::vector<Spread>& all) {
        rule_.drop_hidden(all, form, values, certainly_above);
    };
    drop(spreads);
    if (heights_.family().tips.any() && spreads.size() > 1) {
        // Beside a tip all that do not grow there are nearly zero.
        std::vector<Spread> plain;
        for (const Spread& s : spreads) {
            const HeightJet<Interval> all = heights_.plain_jet(s.form, X, Y);
            plain.push_back({s.form, {}, heights_.plain_jet(s.form, mx, my).v, all.gx, all.gy, all.v, {}});
        }
        drop(plain);
        std::erase_if(spreads, [&](const Spread& s) {
            return std::ranges::find(plain, s.form, &Spread::form) == plain.end();
        });
    }
    return spreads;
}

SmallVector<MixedAnalysis::Rival, MixedAnalysis::usual_rivals> MixedAnalysis::lowest_supports(
    const NormalBox& box, std::span<const FormId> candidates) const {
    SmallVector<Rival, usual_rivals> rivals;
    Support best;
    double nearest = -infinity;
    for (const FormId f : candidates) {
        const Support s = supports_->over(f, box);
        if (const double q = box.middle(s); q > nearest) {
            nearest = q;
            best = s;
        }
        rivals.push_back({f, s});
    }
    rivals.erase(std::remove_if(rivals.begin(), rivals.end(),
                                [&](const Rival& r) { return box.is_above(r.support, best); }),
                 rivals.end());
    if (rivals.size() > 2 && rivals.size() <= most_compared_in_pairs)
        drop_dominated(rivals, [&](const Rival& a, const Rival& b) {
            return box.middle(a.support) < box.middle(b.support) && box.is_above(a.support, b.support);
        });
    return rivals;
}

// Supports are compared with errors that are parts of the heights.
bool MixedAnalysis::have_twins(const SmallVector<Rival, usual_rivals>& rivals) const {
    if (rivals.size() > most_compared_in_pairs) return false;
    for (std::size_t i = 0; i < rivals.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (heights_.are_twins(rivals[i].form, rivals[j].form)) return true;
    return false;
}

// Without the forms that are known to be nowhere lowest over a range of y, but where they tie with others.
std::vector<FormId> MixedAnalysis::not_hidden(std::span<const FormId> candidates, const Interval& y) const {
    std::vector<FormId> open;
    if (heights_.family().hidden.empty()) return open;
    for (const FormId f : candidates)
        if (!heights_.family().is_hidden(f, y)) open.push_back(f);
    return open;
}

std::vector<FormId> MixedAnalysis::cull(const std::array<double, 4>& box,
                                        std::span<const FormId> candidates) {
    normals_.reset();
    const std::vector<FormId> open = not_hidden(candidates, {box[2], box[3]});
    if (!heights_.family().hidden.empty()) candidates = open;
    if (compare_by_supports(std::max(box[1] - box[0], box[3] - box[2]),
                            extent_at({box[0], box[1]}, {box[2], box[3]}))) {
        normals_.emplace(box[0], box[1], box[2], box[3]);
        spreads_.clear();
        const auto rivals = lowest_supports(*normals_, candidates);
        for (const Rival& r : rivals) {
            Spread& s = append_new(spreads_);
            s.form = r.form;
            s.support = r.support;
        }
        if (have_twins(rivals)) {
            normals_.reset();
            SmallVector<FormId, usual_rivals> left;
            for (const Rival& r : rivals) left.push_back(r.form);
            spreads_ = lowest_spreads(box, {left.begin(), left.end()});
        }
    } else {
        spreads_ = lowest_spreads(box, candidates);
    }
    decisions_.by_interval += candidates.size() - 1;
    std::vector<FormId> kept;
    kept.reserve(spreads_.size());
    for (const Spread& s : spreads_) kept.push_back(s.form);
    return kept;
}

// As cull(), by Taylor's formula about the middle. Pre: bend() was called.
void MixedAnalysis::cull_by_curvature(Work& work) {
    const std::size_t before = work.rivals.size();
    rule_.drop_hidden(
        work.rivals, [](const Spread& s) { return s.form; },
        [&](const Spread& a, const Spread& b) {
            const HeightDifference d = work.difference(a, b);
            return d.value(d.dx, d.dy).lower() > 0;
        });
    decisions_.by_interval += before - work.rivals.size();
    if (work.rivals.size() < before) work.is_divided = false;
}

// Is g - f certainly positive all over the piece? Asked where its gradient may vanish: about that place it
// changes least.
bool MixedAnalysis::stays_above(const Work& work, const Spread& g, const Spread& f) const {
    const HeightDifference d = work.difference(g, f);
    const auto& box = work.piece.box;
    const auto [offset, value] = d.stationary();
    if (!(value > 0) || !offset.allFinite()) return false;
    const Vector2d m = work.middle();
    const double x = std::clamp(m.x() + offset.x(), box[0], box[1]),
                 y = std::clamp(m.y() + offset.y(), box[2], box[3]);
    const HeightJet<Interval> at = heights_.difference(g.form, f.form, Interval(x), Interval(y));
    const Interval dx = Interval(box[0], box[1]) - Interval(x), dy = Interval(box[2], box[3]) - Interval(y);
    Interval range = at.v + at.gx * dx + at.gy * dy;
    // A convex function lies above its tangent planes.
    if (!d.is_convex())
        range = range + 0.5 * (d.curvature.xx * square(dx) + 2.0 * (d.curvature.xy * dx * dy) +
                               d.curvature.yy * square(dy));
    return range.lower() > 0;
}

// Let g be lowest nowhere on the rim. Inside it is lowest nowhere, too,
//
//   * if its differences to all forms that are lowest on the rim grow in one direction all over the piece:
//   their
//     maximum is how far g lies above the lowest of these; it grows in that direction from where the line
//     meets the rim, and it is not negative there;
//   * if one form f is lowest all along the rim, and g - f is concave along some direction: on each line of
//   that
//     it is not negative at the ends, so positive between them;
//   * if it lies above one of them all over the piece;
//   * if g ties in no point with two others, and all differences grow in some direction or are concave along
//     one. For around a component of where g is lowest alone there would be one other form f, equal to g
//     there; of what that curve encloses g - f would be least inside, and negative.
//
// What ties with others in a vertex of the rim is left for the faces around that.
void MixedAnalysis::cull_from_rim(Work& work) {
    const auto ties_on_rim = [&](FormId f) {
        return std::ranges::any_of(work.knots, [&](std::uint32_t v) {
            const std::vector<FormId>& ties = work.piece.vertices[v].ties;
            return std::ranges::find(ties, f) != ties.end();
        });
    };
    // Beside a floor what is lowest need not show.
    if (!rule_.spares(work.forms())) return;
    const std::size_t before = work.rivals.size();
    SmallVector<FormId, usual_rivals> rim;
    for (const Spread& s : work.rivals)
        if (work.is_on_rim(s.form)) rim.push_back(s.form);
    if (rim.size() == before || rim.size() == 0) return;
    const auto is_above = [&](const Spread& g) {
        SmallVector<Work::Gradient, usual_rivals> gradients;
        for (const FormId f : rim) gradients.push_back(work.gradient(g, *work.find(f)));
        if (Work::grow_together({gradients.begin(), gradients.size()})) return true;
        if (!g.bend) return false;
        if (rim.size() == 1 && !work.supports && work.direction(g, *work.find(rim[0]))) return true;
        const auto is_concave = [&](const Spread& s) { return work.difference(g, s).is_concave_somewhere(); };
        if (rim.size() == 1 && is_concave(*work.find(rim[0]))) return true;
        if (std::ranges::any_of(rim, [&](FormId f) { return stays_above(work, g, *work.find(f)); }))
            return true;
        if (rim.size() == 1 || work.supports || work.rivals.size() > most_divided) return false;
        const std::vector<Spread>& r = work.rivals;
        for (const Spread& s : r)
            if (&s != &g && !work.direction(g, s) && !is_concave(s)) return false;
        for (std::size_t i = 0; i < r.size(); ++i)
            for (std::size_t j = i + 1; j < r.size(); ++j)
                if (&r[i] != &g && &r[j] != &g && work.turn(g, r[i], r[j]) != Sign::Zero) return false;
        return true;
    };
    for (std::size_t i = 0; i < work.rivals.size();)
        if (const Spread& g = work.rivals[i]; !work.is_on_rim(g.form) && !ties_on_rim(g.form) && is_above(g))
            work.rivals.erase(work.rivals.begin() + static_cast<std::ptrdiff_t>(i));
        else
            ++i;
    decisions_.by_interval += before - work.rivals.size();
    if (work.rivals.size() < before) work.is_divided = false;
}

// As cull(), with values that doubles do not tell apart.
void MixedAnalysis::cull_sharply(Work& work) {
    struct Item {
        const Spread* spread;
        Wide v;
    };
    const auto& box = work.piece.box;
    const Vector2d m = work.middle();
    const Interval rx(Interval::up(std::max(box[1] - m.x(), m.x() - box[0]))),
        ry(Interval::up(std::max(box[3] - m.y(), m.y() - box[2])));
    std::vector<Item> items;
    for (const Spread& s : work.rivals)
        items.push_back({&s, heights_.value(s.form, Wide(m.x()), Wide(m.y()))});
    const auto certainly_above = [&](const Item& a, const Item& b) {
        const auto [gx, gy] = work.gradient(*a.spread, *b.spread);
        return ((a.v - b.v).enclosure() - gx.magnitude() * rx - gy.magnitude() * ry).lower() > 0;
    };
    rule_.drop_hidden(
        items, [](const Item& i) { return i.spread->form; }, certainly_above);
    decisions_.by_multiprecision += work.rivals.size() - items.size();
    std::vector<Spread> kept;
    for (const Item& i : items) kept.push_back(*i.spread);
    work.rivals = std::move(kept);
}

std::optional<double> MixedAnalysis::steepness_across(double along_x, double along_y) const {
    if (normals_) return std::nullopt;  // supports bound no gradients of forms alone
    double x = 0, y = 0;
    for (std::size_t i = 0; i < spreads_.size(); ++i)
        for (std::size_t j = 0; j < std::min(i, most_compared_in_pairs); ++j) {
            x += (spreads_[i].gx - spreads_[j].gx).magnitude() * along_x;
            y += (spreads_[i].gy - spreads_[j].gy).magnitude() * along_y;
        }
    return x + y > 0 && std::isfinite(x + y) ? std::optional(x / y) : std::nullopt;
}

std::optional<bool> MixedAnalysis::asks_for_strips(const std::array<double, 4>& box) const {
    constexpr double strip_ratio = 8;
    if (spreads_.size() < 3 || spreads_.size() > most_divided) return std::nullopt;
    const Interval X(box[0], box[1]), Y(box[2], box[3]);
    // Without tips heights are plain, and known where a diagram was asked for.
    const bool are_known = !heights_.family().tips.any() &&
                           std::ranges::all_of(spreads_, [](const Spread& s) { return s.bend.has_value(); });
    SmallVector<Heights::PlainGradient, most_divided> gradients;
    if (!are_known)
        for (const Spread& s : spreads_) gradients.push_back(heights_.plain_gradient(s.form, X, Y));
    double x = 0, y = 0;
    for (std::size_t i = 0; i < spreads_.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const auto [gx, gy] =
                are_known ? bent_gradient({spreads_[i].gx - spreads_[j].gx, spreads_[i].gy - spreads_[j].gy},
                                          spreads_[i], spreads_[j])
                          : Heights::difference(gradients[i], gradients[j], X, Y);
            x += gx.magnitude() * (box[1] - box[0]);
            y += gy.magnitude() * (box[3] - box[2]);
        }
    if (!std::isfinite(x + y)) return std::nullopt;
    return x > strip_ratio * y   ? std::optional(true)
           : y > strip_ratio * x ? std::optional(false)
                                 : std::nullopt;
}

}  // namespace vcell
