#include "box_rivals.hpp"

#include <algorithm>
#include <cmath>

#include "dominated.hpp"
#include "height_difference.hpp"
#include "mixed_terms.hpp"

namespace vcell {

void BoxRivals::bend(const std::array<double, 4>& box) {
    const Interval X(box[0], box[1]), Y(box[2], box[3]), mx(X.mid()), my(Y.mid());
    for (Spread& s : spreads_)
        s.bend = {heights_.jet(s.form, mx, my), heights_.curvature(s.form, X, Y), X - mx, Y - my};
}

std::array<Interval, 2> bent_gradient(const std::array<Interval, 2>& over, const Spread& a, const Spread& b) {
    const auto &p = *a.bend, &q = *b.bend;
    return refined_gradient(over, {p.middle.gx - q.middle.gx, p.middle.gy - q.middle.gy},
                            p.curvature - q.curvature, p.dx, p.dy);
}

// Does the first of two twins lie above the other all over the box?
bool BoxRivals::is_above_twin(FormId f, FormId g, const Interval& X, const Interval& Y) const {
    const auto over = *heights_.twin_difference(f, g, X, Y);
    if (over.v.lower() > 0) return true;
    const Interval middle = heights_.twin_difference(f, g, X.mid(), Y.mid())->v;
    return (middle - over.x.magnitude() * Interval(X.radius()) - over.y.magnitude() * Interval(Y.radius()))
               .lower() > 0;
}

std::vector<Spread> BoxRivals::lowest_spreads(const std::array<double, 4>& box,
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
               // What is subtracted is not negative.
               (a.v.lower() > b.v.upper() && (a.v - b.v - (a.gx - b.gx).magnitude() * Interval(rx) -
                                              (a.gy - b.gy).magnitude() * Interval(ry))
                                                     .lower() > 0) ||
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

std::vector<FormId> BoxRivals::cull(const std::array<double, 4>& box, std::span<const FormId> candidates) {
    normals_.reset();
    const std::vector<FormId> open = all_.not_hidden(candidates, {box[0], box[1]}, {box[2], box[3]});
    if (!heights_.family().hidden.empty()) candidates = open;
    if (all_.compare_by_supports(std::max(box[1] - box[0], box[3] - box[2]),
                                 all_.extent_at({box[0], box[1]}, {box[2], box[3]}))) {
        normals_.emplace(box[0], box[1], box[2], box[3]);
        spreads_.clear();
        const auto rivals = all_.lowest_supports(*normals_, candidates);
        for (const SupportRival& r : rivals) {
            Spread& s = append_new(spreads_);
            s.form = r.form;
            s.support = r.support;
        }
        if (all_.have_twins(rivals)) {
            normals_.reset();
            SmallVector<FormId, usual_rivals> left;
            for (const SupportRival& r : rivals) left.push_back(r.form);
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

std::optional<double> BoxRivals::steepness_across(double along_x, double along_y) const {
    if (normals_) return std::nullopt;  // supports bound no gradients of forms alone
    double x = 0, y = 0;
    for (std::size_t i = 0; i < spreads_.size(); ++i)
        for (std::size_t j = 0; j < std::min(i, most_compared_in_pairs); ++j) {
            x += (spreads_[i].gx - spreads_[j].gx).magnitude() * along_x;
            y += (spreads_[i].gy - spreads_[j].gy).magnitude() * along_y;
        }
    return x + y > 0 && std::isfinite(x + y) ? std::optional(x / y) : std::nullopt;
}

std::optional<bool> BoxRivals::asks_for_strips(const std::array<double, 4>& box) const {
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
