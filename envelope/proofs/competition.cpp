#include "competition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dominated.hpp"
#include "mixed_terms.hpp"

namespace vcell {

Competition::Competition(const FormFamily& family, double extent, const EnvelopeOptions& options)
    : heights_(family), rule_(family, options), extent_(extent) {
    if (family.compared_over().is_sphere()) supports_.emplace(family);
}

// A point of the rim may be met from its side and from inside.
bool add_assumption(Assumption assumption, std::vector<Assumption>& known) {
    const auto& [place, width, forms] = assumption;
    for (Assumption& k : known) {
        const double same = k.width + width + 4 * std::numeric_limits<double>::epsilon() * place.norm();
        if (k.forms != forms || (k.place - place).norm() > same) continue;
        k.width = std::max(k.width, width);
        return false;
    }
    known.push_back(std::move(assumption));
    return true;
}

void Competition::assume(const Eigen::Vector2d& place, double width, std::vector<FormId> forms) {
    std::ranges::sort(forms);
    if (add_assumption({place, width, std::move(forms)}, assumptions_)) ++decisions_.assumed;
}

SupportRivals Competition::lowest_supports(const NormalBox& box, std::span<const FormId> candidates) const {
    SupportRivals rivals;
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
                                [&](const SupportRival& r) { return box.is_above(r.support, best); }),
                 rivals.end());
    if (rivals.size() > 2 && rivals.size() <= most_compared_in_pairs)
        drop_dominated(rivals, [&](const SupportRival& a, const SupportRival& b) {
            return box.middle(a.support) < box.middle(b.support) && box.is_above(a.support, b.support);
        });
    return rivals;
}

bool Competition::have_twins(const SupportRivals& rivals) const {
    if (rivals.size() > most_compared_in_pairs) return false;
    for (std::size_t i = 0; i < rivals.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (heights_.are_twins(rivals[i].form, rivals[j].form)) return true;
    return false;
}

std::vector<FormId> Competition::not_hidden(std::span<const FormId> candidates, const Interval& x,
                                            const Interval& y) const {
    std::vector<FormId> open;
    if (heights_.family().hidden.empty()) return open;
    for (const FormId f : candidates)
        if (!heights_.family().is_hidden(f, x, y)) open.push_back(f);
    return open;
}

std::optional<FormId> Competition::certainly_lowest(const IntervalPoint& p,
                                                    std::span<const FormId> candidates) const {
    if (!supports_ || !is_point(p[0]) || !is_point(p[1])) return std::nullopt;
    const PointNormal n(p[0].mid(), p[1].mid());
    FormId lowest;
    double top = infinity, next = infinity;  // of the lowest one; the bottom of all others
    for (const FormId f : candidates) {
        const double v = supports_->value(f, n), r = supports_->value_error(f, n);
        if (v < top) {
            next = std::min(next, lowest.valid() ? top - 2 * supports_->value_error(lowest, n) : infinity);
            top = v + r;
            lowest = f;
        } else {
            next = std::min(next, v - r);
        }
    }
    return top < next ? std::optional(lowest) : std::nullopt;
}

bool Competition::is_met(FormId f, const Interval& x, const Interval& y) const {
    const FormFamily& family = heights_.family();
    const Interval height = heights_.value(f, x, y);
    if (height.sign() != family.compared_over().sign_of_met()) return false;
    for (std::uint32_t i = 0; i < family.cylinders.size(); ++i) {
        if (!family.cylinders[i].is_hollow()) continue;
        const FormId hollow{static_cast<std::uint32_t>(family.forms.size()) + i};
        if (heights_.root_at(hollow, x, y, height).sign() != Sign::Negative) return false;
    }
    return true;
}

bool Competition::is_well_known(const Eigen::Vector2d& p, double error, std::span<const FormId> forms,
                                double extent) const {
    constexpr double enough = 0x1p-33;
    double slope = 0;
    if (!supports_)
        for (const FormId f : forms) {
            const auto [height, gx, gy] = heights_.near(f, p.x(), p.y());
            slope = std::max(slope, std::hypot(gx, gy));
        }
    return error * (1 + slope) <= enough * extent;
}

}  // namespace vcell
