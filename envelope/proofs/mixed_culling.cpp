// Which forms compete in a piece, and how it is best divided.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mixed_work.hpp"

namespace vcell {

MixedAnalysis::MixedAnalysis(const FormFamily& family, double extent) : heights_(family), extent_(extent) {
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
    drop_out_of_range(spreads);
    for (Spread& s : spreads) s.v = heights_.value(s.form, mx, my);
    const auto certainly_above = [&](const Spread& a, const Spread& b) {
        return a.range.lower() > b.range.upper() || (a.v - b.v - (a.gx - b.gx).magnitude() * Interval(rx) -
                                                     (a.gy - b.gy).magnitude() * Interval(ry))
                                                            .lower() > 0;
    };
    const auto top = [&](const Spread& s) {
        return std::min(s.range.upper(), s.v.upper() + s.gx.magnitude() * rx + s.gy.magnitude() * ry);
    };
    drop_above_best(spreads, top, certainly_above);
    if (heights_.family().tips.any() && spreads.size() > 1) {
        // Beside a tip all that do not grow there are nearly zero.
        std::vector<Spread> plain;
        for (const Spread& s : spreads) {
            const HeightJet<Interval> all = heights_.plain_jet(s.form, X, Y);
            plain.push_back({s.form, {}, heights_.plain_jet(s.form, mx, my).v, all.gx, all.gy, all.v, {}});
        }
        drop_above_best(plain, top, certainly_above);
        auto kept = plain.begin();  // in the same order
        std::erase_if(spreads, [&](const Spread& s) {
            const bool is_kept = kept != plain.end() && kept->form == s.form;
            if (is_kept) ++kept;
            return !is_kept;
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

std::vector<FormId> MixedAnalysis::cull(const std::array<double, 4>& box,
                                        std::span<const FormId> candidates) {
    normals_.reset();
    if (compare_by_supports(std::max(box[1] - box[0], box[3] - box[2]),
                            extent_at({box[0], box[1]}, {box[2], box[3]}))) {
        normals_.emplace(box[0], box[1], box[2], box[3]);
        spreads_.clear();
        for (const Rival& r : lowest_supports(*normals_, candidates)) {
            Spread& s = append_new(spreads_);
            s.form = r.form;
            s.support = r.support;
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
    SmallVector<Heights::PlainGradient, most_divided> gradients;
    for (const Spread& s : spreads_) gradients.push_back(heights_.plain_gradient(s.form, X, Y));
    double x = 0, y = 0;
    for (std::size_t i = 0; i < gradients.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const auto [gx, gy] = Heights::difference(gradients[i], gradients[j], X, Y);
            x += gx.magnitude() * (box[1] - box[0]);
            y += gy.magnitude() * (box[3] - box[2]);
        }
    if (!std::isfinite(x + y)) return std::nullopt;
    return x > strip_ratio * y   ? std::optional(true)
           : y > strip_ratio * x ? std::optional(false)
                                 : std::nullopt;
}

}  // namespace vcell
