/// Which of several forms shows where some of them are a floor (EnvelopeOptions::floor).
///
/// Let h be the least of the other forms and e the greatest of the floor's. The diagram above the floor shows
/// e where e > h, that below it where e < h, and h elsewhere. Of two forms of one kind that is the lower one,
/// or of the floor the greater one; of two of both kinds the greater one above the floor and the lower one
/// below it. Among three that relation need not be transitive: of h_1 < e < h_2 above the floor e shows, as
/// h_1 beats h_2. So what loses to one form is not simply left out:
///
///   * what loses to one of its own kind is;
///   * if e_w > h_i for some pair, e > h, and one kind shows alone;
///   * a form that may not show itself may still be what hides the other kind's (below the floor the greatest
///     of the floor's, above it the least of the others). Forms that lose to all of the other kind are left
///     out where they cannot: above the floor the floor's, below it the others.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "dominated.hpp"

namespace vcell {

class FloorRule {
public:
    FloorRule() = default;
    FloorRule(const FormFamily& family, const EnvelopeOptions& options)
        : is_below_(options.is_below_floor), is_any_(!options.floor.empty()) {
        if (!is_any_) return;
        is_of_floor_.assign(family.size(), false);
        for (const FormId f : options.floor) is_of_floor_[f.value] = true;
    }

    bool is_any() const { return is_any_; }
    bool is_of_floor(FormId f) const { return is_any_ && is_of_floor_[f.value]; }
    /// Does the greater one of these two show?
    bool shows_greater(FormId f, FormId g) const {
        if (!is_any_) return false;
        const bool l = is_of_floor_[f.value], r = is_of_floor_[g.value];
        return (l && r) || (!is_below_ && (l || r));
    }
    /// Are these forms compared as without a floor, the lowest one showing?
    template <class Forms>
    bool spares(const Forms& forms) const {
        return !is_any_ || std::ranges::none_of(forms, [&](FormId f) { return is_of_floor_[f.value]; });
    }

    /// Do three forms that tie in a vertex, with gradients that turn one way, follow each other around it the
    /// other way round than the lowest ones of three do? Of the six orders of three values that
    /// follow each other around the vertex the lowest, and the greatest, of the three owns two each. Where a
    /// form is hidden by the greatest, or the least, of the two of the other kind, it shows in four and each
    /// of these in one of the two that are left, in the other succession.
    bool turns_round(FormId f, FormId g, FormId h) const {
        const int of_floor = is_of_floor(f) + is_of_floor(g) + is_of_floor(h);
        return of_floor == (is_below_ ? 2 : 1);
    }

    /// Leaves out what certainly shows nowhere; above(a, b): is a certainly above b? Without a floor what is
    /// above another one.
    template <class Items, class Form, class Above>
    void drop_hidden(Items& items, Form&& form, Above&& above) const {
        if (!is_any_) return drop_dominated(items, above);
        const auto floor = [&](const auto& i) { return is_of_floor(form(i)); };
        std::vector<char> hidden(items.size(), false);
        bool is_floor_higher = false;
        for (std::size_t i = 0; i < items.size(); ++i)
            for (std::size_t j = 0; j < items.size(); ++j) {
                if (i == j) continue;
                const bool f = floor(items[i]);
                if (f == floor(items[j]))
                    hidden[i] = hidden[i] ||
                                (!hidden[j] && (f ? above(items[j], items[i]) : above(items[i], items[j])));
                else
                    is_floor_higher = is_floor_higher || (f && above(items[i], items[j]));
            }
        if (is_floor_higher) {
            for (std::size_t i = 0; i < items.size(); ++i)
                hidden[i] = hidden[i] || floor(items[i]) == is_below_;
        } else {
            // Above the floor a form of the floor below all others, below it another one above all of it.
            const std::vector<char> before = hidden;
            for (std::size_t i = 0; i < items.size(); ++i) {
                if (floor(items[i]) == is_below_) continue;
                bool has_others = false, loses = true;
                for (std::size_t j = 0; j < items.size(); ++j) {
                    if (before[j] || floor(items[j]) != is_below_) continue;
                    has_others = true;
                    loses = loses && (is_below_ ? above(items[i], items[j]) : above(items[j], items[i]));
                }
                hidden[i] = hidden[i] || (has_others && loses);
            }
        }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < items.size(); ++i)
            if (!hidden[i]) std::swap(items[kept++], items[i]);
        items.resize(kept);
    }

    /// Leaves out what shows nowhere of any number of items, in time linear in it: what the best of its own
    /// kind hides goes first, so that few are left to be compared in pairs, as above.
    template <class Items, class Form, class Range, class Above>
    void drop_hidden(Items& items, Form&& form, Range&& range, Above&& above) const {
        drop_worse_than_best(items, form, range, above);
        if (items.size() > 1 && items.size() <= most_compared_in_pairs) drop_hidden(items, form, above);
    }

    /// Leaves out what ranges of values alone tell to be hidden by its own kind.
    template <class Items, class Form>
    void drop_out_of_range(Items& items, Form&& form) const {
        double top = Interval::whole().upper(), bottom = -top;
        for (const auto& i : items)
            if (is_of_floor(form(i)))
                bottom = std::max(bottom, i.range.lower());
            else
                top = std::min(top, i.range.upper());
        std::erase_if(items, [&](const auto& i) {
            return is_of_floor(form(i)) ? i.range.upper() < bottom : i.range.lower() > top;
        });
    }

    /// Those of the candidates that may show where values are enclosed by `value`.
    template <class Value>
    std::vector<FormId> possibly_showing(std::span<const FormId> candidates, Value&& value) const {
        struct Item {
            FormId form;
            Interval value;
        };
        std::vector<Item> items;
        for (const FormId f : candidates) items.push_back({f, value(f)});
        drop_hidden(
            items, [](const Item& i) { return i.form; },
            [](const Item& a, const Item& b) { return a.value.lower() > b.value.upper(); });
        std::vector<FormId> forms;
        for (const Item& i : items) forms.push_back(i.form);
        std::ranges::sort(forms);
        return forms;
    }

    /// Those of the candidates that show at a point, where compare(f, g) is the sign of f - g there: all that
    /// tie.
    template <class Compare>
    std::vector<FormId> exactly_showing(std::span<const FormId> candidates, Compare&& compare) const {
        std::vector<FormId> least, greatest;  // of the other forms, of the floor's
        for (const FormId f : candidates) {
            std::vector<FormId>& best = is_of_floor(f) ? greatest : least;
            Sign s = best.empty() ? Sign::Negative : compare(f, best.front());
            if (!best.empty() && is_of_floor(f)) s = -s;
            if (s == Sign::Negative) best.clear();
            if (s != Sign::Positive) best.push_back(f);
        }
        if (least.empty() || greatest.empty()) return least.empty() ? greatest : least;
        const Sign above = compare(least.front(), greatest.front());
        if (above == Sign::Zero) {
            least.insert(least.end(), greatest.begin(), greatest.end());
            return least;
        }
        return (above == Sign::Positive) == is_below_ ? greatest : least;
    }

    /// Does a vertex of three forms show among others, given the sign of each of these less the vertex's
    /// value? sign(f) of all others.
    template <class Sign_of>
    bool shows_vertex(std::span<const FormId> three, std::span<const FormId> others, Sign_of&& sign) const {
        bool has_floor = false, has_other = false, floor_above = false, other_below = false,
             any_floor = false, any_other = false;
        for (const FormId f : three) (is_of_floor(f) ? has_floor : has_other) = true;
        for (const FormId f : others) {
            const Sign s = sign(f);
            if (is_of_floor(f)) {
                any_floor = true;
                floor_above = floor_above || s == Sign::Positive;
            } else {
                any_other = true;
                other_below = other_below || s == Sign::Negative;
            }
        }
        if ((has_floor && floor_above) || (has_other && other_below)) return false;
        if (has_floor && has_other) return true;
        if (has_other) return is_below_ ? floor_above || !any_floor : !floor_above;
        return is_below_ ? !other_below : other_below || !any_other;
    }

private:
    // Leaves out what the best of its own kind hides: of a floor that whose values, within range(i), are
    // greatest at least, otherwise that whose values are least at most.
    template <class Items, class Form, class Range, class Above>
    void drop_worse_than_best(Items& items, Form&& form, Range&& range, Above&& above) const {
        if (items.size() < 2) return;
        using Item = std::ranges::range_value_t<Items>;
        const double infinity = Interval::whole().upper();
        double greatest = -infinity, least = infinity;
        const Item *floor = nullptr, *other = nullptr;
        for (const Item& i : items) {
            const Interval r = range(i);
            if (is_of_floor(form(i))) {
                if (floor == nullptr || r.lower() > greatest) floor = &i;
                greatest = std::max(greatest, r.lower());
            } else {
                if (other == nullptr || r.upper() < least) other = &i;
                least = std::min(least, r.upper());
            }
        }
        if (floor == nullptr) {
            const Item best = *other;
            std::erase_if(items, [&](const Item& i) { return above(i, best); });
            return;
        }
        const Item best_floor = *floor, best_other = other != nullptr ? *other : Item();
        std::erase_if(items, [&](const Item& i) {
            return is_of_floor(form(i)) ? above(best_floor, i) : above(i, best_other);
        });
    }

    std::vector<char> is_of_floor_;
    bool is_below_ = false, is_any_ = false;
};

}  // namespace vcell
