#include "competing_forms.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "../../core/platform.hpp"

namespace vcell {

namespace {

using Item = CompetingForms::Item;

// So many forms are no faster in groups, measured (bench_envelope).
constexpr std::size_t most_ungrouped = 2048;
constexpr Item group_size = 4;
// Groups are looked at in parts as long as they are larger than this part of the rectangle, or as most of a
// sample of their forms are culled: where widths differ, far away few of a group may be left.
constexpr double largest_part = 1;
constexpr std::size_t sample_size = 32, least_of_sample = 8;

// Where a form is least.
struct Place {
    double x, y;
    Item item;
};

// Puts places that lie together side by side, so that each group_size^k of them from a multiple of that
// number on are in a box that no others divide.
void put_together(std::span<Place> places) {
    if (places.size() <= group_size) return;
    double x0 = HUGE_VAL, x1 = -HUGE_VAL, y0 = HUGE_VAL, y1 = -HUGE_VAL;
    for (const Place& p : places) {
        x0 = std::min(x0, p.x);
        x1 = std::max(x1, p.x);
        y0 = std::min(y0, p.y);
        y1 = std::max(y1, p.y);
    }
    std::size_t block = group_size;
    while (group_size * block < places.size()) block *= group_size;
    const std::size_t half = (places.size() / block + 1) / 2 * block;
    const auto middle = places.begin() + static_cast<std::ptrdiff_t>(half);
    std::ranges::nth_element(places, middle, {}, x1 - x0 >= y1 - y0 ? &Place::x : &Place::y);
    put_together(places.first(half));
    put_together(places.subspan(half));
}

}  // namespace

CompetingForms::CompetingForms(const CircularFamily& family, std::span<const FormId> forms) {
    ids_.assign(forms.begin(), forms.end());
    for (const FormId f : forms) forms_.push_back(KernelForm::of(family.forms[f]));
    if (forms.size() <= most_ungrouped) {
        for (Item i = 0; i < forms.size(); ++i) top_.push_back(i);
        return;
    }
    std::vector<Place> places;
    std::vector<Item> order, others;  // others are least nowhere, or so far away that no number bounds them
    for (Item i = 0; i < forms.size(); ++i) {
        const Group g = group_of(forms_[i], i);
        const bool is_bounded = std::isfinite(g.places.x0) && std::isfinite(g.places.x1) &&
                                std::isfinite(g.places.y0) && std::isfinite(g.places.y1) &&
                                std::isfinite(g.curvature) && std::isfinite(g.value);
        if (g.curvature > 0 && is_bounded)
            places.push_back(
                {0.5 * g.places.x0 + 0.5 * g.places.x1, 0.5 * g.places.y0 + 0.5 * g.places.y1, i});
        else
            others.push_back(i);
    }
    put_together(places);
    for (const Place& p : places) order.push_back(p.item);
    order.insert(order.end(), others.begin(), others.end());
    std::vector<Form> in_order;
    for (Item i = 0; i < order.size(); ++i) {
        in_order.push_back(forms_[order[i]]);
        ids_[i] = forms[order[i]];
    }
    forms_ = std::move(in_order);

    const auto size = static_cast<Item>(forms_.size()), grouped = static_cast<Item>(places.size());
    add_level(0, grouped);
    for (Item first = size; groups_.size() - (first - size) > 1;) {
        const Item end = size + static_cast<Item>(groups_.size());
        add_level(first, end);
        first = end;
    }
    if (!groups_.empty()) top_.push_back(size + static_cast<Item>(groups_.size()) - 1);
    for (Item i = grouped; i < size; ++i) top_.push_back(i);
}

// f = K |p - q|^2 + m in numbers whose errors the bounds contain, or in infinite ones: k and q are exact
// where a = b = 0, and K, a, b, e and 1 / w are within 10 roundings else.
CompetingForms::Group CompetingForms::group_of(const Form& f, Item item) {
    constexpr double part = 16 * roundoff::u;
    const double dx = -0.5 * f.a / f.k, dy = -0.5 * f.b / f.k;
    const double x = f.cx + dx, y = f.cy + dy, ex = part * (std::abs(f.cx) + std::abs(dx)),
                 ey = part * (std::abs(f.cy) + std::abs(dy));
    const double deepest = f.k * (dx * dx + dy * dy);
    return {{x - ex, x + ex, y - ey, y + ey},
            f.K * (1 - part),
            (f.e - deepest) * f.iw - 2 * part * (std::abs(f.e) + deepest) * f.iw,
            item,
            item,
            item,
            item + 1,
            item,
            1};
}

void CompetingForms::add_level(Item first, Item end) {
    for (Item i = first; i < end; i += group_size) {
        Group all = is_group(i) ? group(i) : group_of(forms_[i], i);
        all.first = i;
        all.end = std::min(end, i + group_size);
        std::array<Item, group_size> middles{all.middle};
        for (Item k = i + 1; k < all.end; ++k) {
            const Group g = is_group(k) ? group(k) : group_of(forms_[k], k);
            all.places = {std::min(all.places.x0, g.places.x0), std::max(all.places.x1, g.places.x1),
                          std::min(all.places.y0, g.places.y0), std::max(all.places.y1, g.places.y1)};
            if (g.curvature < all.curvature) {
                all.curvature = g.curvature;
                all.widest = g.widest;
            }
            all.value = std::min(all.value, g.value);
            all.count += g.count;
            middles[k - i] = g.middle;
        }
        const double x = 0.5 * all.places.x0 + 0.5 * all.places.x1,
                     y = 0.5 * all.places.y0 + 0.5 * all.places.y1;
        const auto height = [&](Item form) { return forms_[form].over_box(x, y, 0, 0).v; };
        all.middle = *std::min_element(middles.begin(), middles.begin() + (all.end - i),
                                       [&](Item f, Item g) { return height(f) < height(g); });
        groups_.push_back(all);
    }
}

std::size_t CompetingForms::count(std::span<const Item> items) const {
    std::size_t sum = 0;
    for (const Item item : items) sum += is_group(item) ? group(item).count : 1;
    return sum;
}

// A group's forms are at least K d^2 + m, d being the distance from the places. In each coordinate d^2 is
// convex, so no less than its tangent d0^2 + 2 d0 t in the rectangle's middle, and more than that by t^2
// where all places are on one side of it. From there on it is what BoxForm::excess() says of two forms,
// with its margin for as many roundings.
bool CompetingForms::Culling::is_above(const Group& group, const BoxForm& rival,
                                       const FormCulling::Middle& at) {
    double excess = group.value - rival.v, scale = std::abs(group.value) + rival.scale;
    const auto add = [&](double low, double high, double middle, double r, double slope) {
        const double d = middle < low ? middle - low : middle > high ? middle - high : 0;
        const double K = (std::abs(d) > r ? group.curvature : 0) - rival.K;
        const double G = std::abs(2 * group.curvature * d - slope), height = group.curvature * (d * d);
        excess += height - G * r + (G > 2 * K * r ? K * (r * r) : 0);
        scale += 4 * (height + group.curvature * (r * r));
    };
    add(group.places.x0, group.places.x1, at.x, at.rx, rival.gx);
    add(group.places.y0, group.places.y1, at.y, at.ry, rival.gy);
    return excess > 64 * std::numeric_limits<double>::epsilon() * scale;
}

// Are few of the forms in groups left if these are looked at one by one?
bool CompetingForms::Culling::hide_much(std::span<const Item> items, const BoxForm& rival,
                                        const FormCulling::Middle& at) const {
    std::size_t forms = 0;
    for (const Item item : items)
        if (forms_->is_group(item)) forms += forms_->group(item).count;
    const std::size_t step = forms / sample_size + 1;
    std::size_t asked = 0, left = 0, next = step / 2;
    for (const Item item : items) {
        if (!forms_->is_group(item)) continue;
        const Group& g = forms_->group(item);
        for (; next < g.count; next += step) {
            ++asked;
            const Form& f = (*forms_)[g.form + static_cast<Item>(next)];
            left += !BoxForm::certainly_above(at.box_form(f), rival, at.rx, at.ry);
        }
        next -= g.count;
    }
    return left * sample_size < asked * least_of_sample;
}

void CompetingForms::Culling::operator()(const Rectangle& r, std::span<const Item> items, std::size_t few,
                                         std::vector<Item>& kept) {
    const FormCulling::Middle at(r);
    open_.assign(items.begin(), items.end());
    const double largest = largest_part * extent(r);
    while (true) {
        kept.clear();
        if (open_.empty()) return;
        // Two forms of a group stand for it in the search for a rival.
        box_forms_.resize(open_.size());
        std::size_t rival = 0;
        for (std::size_t i = 0; i < open_.size(); ++i) {
            const Item item = open_[i];
            BoxForm& form = box_forms_[i];
            if (forms_->is_group(item)) {
                const Group& g = forms_->group(item);
                form = at.box_form((*forms_)[g.middle]);
                if (const auto wide = at.box_form((*forms_)[g.widest]); wide.top < form.top) form = wide;
            } else {
                form = at.box_form((*forms_)[item]);
            }
            if (form.top < box_forms_[rival].top) rival = i;
        }
        const BoxForm& lowest = box_forms_[rival];
        bool has_group = false;
        for (std::size_t i = 0; i < open_.size(); ++i) {
            const Item item = open_[i];
            const bool is_group = forms_->is_group(item);
            if (is_group ? is_above(forms_->group(item), lowest, at)
                         : BoxForm::certainly_above(box_forms_[i], lowest, at.rx, at.ry))
                continue;
            has_group |= is_group;
            kept.push_back(item);
        }
        if (!has_group) return;
        const bool are_few = forms_->count(kept) <= few;
        const bool open_all = are_few || hide_much(kept, lowest, at);
        const auto is_large = [&](Item item) {
            return forms_->is_group(item) && extent(forms_->group(item).places) > largest;
        };
        if (!open_all && std::ranges::none_of(kept, is_large)) return;
        open_.clear();
        for (const Item item : kept) {
            if (are_few)
                forms_->for_forms(item, [&](Item form) { open_.push_back(form); });
            else if (!forms_->is_group(item) || (!open_all && !is_large(item)))
                open_.push_back(item);
            else
                for (Item i = forms_->group(item).first; i < forms_->group(item).end; ++i) open_.push_back(i);
        }
    }
}

}  // namespace vcell
