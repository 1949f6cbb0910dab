/// Which circular forms may be lowest somewhere in a rectangle.
///
/// Many forms are kept in groups of groups of forms that lie together, so that those which are far from a
/// rectangle are left out together: culled one by one they would be looked at again in every piece of a
/// region that is large beside their distance.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "pieces.hpp"

namespace vcell {

/// Looks at forms one by one. Working space, for one thread.
class FormCulling {
public:
    using Form = KernelForm;

    /// Calls keep(i) for those of the items, numbers i = 0, 1, ..., whose forms form(item) may be lowest
    /// somewhere in the rectangle: for all that are not certainly above a rival all over it. The best rival
    /// is the one whose highest value in the rectangle is lowest.
    template <class Item, class FormOf, class Keep>
    void operator()(const Rectangle& r, std::span<const Item> items, FormOf&& form, Keep&& keep) {
        const Middle at(r);
        box_forms_.resize(items.size());
        std::size_t rival = 0;
        for (std::size_t i = 0; i < items.size(); ++i) {
            box_forms_[i] = at.box_form(form(items[i]));
            if (box_forms_[i].top < box_forms_[rival].top) rival = i;
        }
        for (std::size_t i = 0; i < items.size(); ++i)
            if (!BoxForm::certainly_above(box_forms_[i], box_forms_[rival], at.rx, at.ry)) keep(i);
    }

    /// A rectangle as KernelForm::over_box() takes it: its middle, and half sides that reach all of it.
    struct Middle {
        explicit Middle(const Rectangle& r)
            : x(0.5 * r.x0 + 0.5 * r.x1),
              y(0.5 * r.y0 + 0.5 * r.y1),
              rx(Interval::up(std::max(r.x1 - x, x - r.x0))),
              ry(Interval::up(std::max(r.y1 - y, y - r.y0))) {}
        BoxForm box_form(const Form& f) const { return f.over_box(x, y, rx, ry); }

        double x, y, rx, ry;
    };

private:
    std::vector<BoxForm> box_forms_;
};

/// Unchanged once it is made: threads may share one, each with a CompetingForms::Culling of its own.
class CompetingForms {
public:
    using Form = KernelForm;
    /// A form, or a group of them.
    using Item = std::uint32_t;

    /// O(n log n).
    CompetingForms(const CircularFamily& family, std::span<const FormId> forms);

    /// Items that hold every form once.
    const std::vector<Item>& all() const { return top_; }
    std::size_t count(std::span<const Item> items) const;

    bool is_group(Item item) const { return item >= forms_.size(); }
    /// Pre: the item is no group.
    const Form& operator[](Item item) const { return forms_[item]; }
    FormId id(Item item) const { return ids_[item]; }
    /// Calls visit(form) for all forms of the item, each an item itself.
    template <class Visit>
    void for_forms(Item item, Visit&& visit) const {
        if (!is_group(item)) return visit(item);
        const Group& g = group(item);
        for (Item form = g.form; form < g.form + g.count; ++form) visit(form);
    }

    class Culling;

private:
    // Forms K |p - q|^2 + m with places q in a box, K no less than the least curvature and m no less than
    // the least value.
    struct Group {
        Rectangle places;
        double curvature, value;
        Item middle, widest;  // forms that stand for them, nearby and far away
        Item first, end;      // of the items in it
        Item form;            // the first of so many in it
        std::uint32_t count;
    };
    const Group& group(Item item) const { return groups_[item - forms_.size()]; }
    static Group group_of(const Form& f, Item item);
    void add_level(Item first, Item end);

    std::vector<Form> forms_;
    std::vector<FormId> ids_;
    std::vector<Group> groups_;
    std::vector<Item> top_;
};

/// Working space, for one thread.
class CompetingForms::Culling {
public:
    /// The competitors must outlive this object.
    explicit Culling(const CompetingForms& forms) : forms_(&forms) {}

    const CompetingForms& forms() const { return *forms_; }

    /// Into `kept`, those items, or parts of them, that may be lowest somewhere in the rectangle, as
    /// FormCulling decides it; two forms of each group are among the rivals. Where no more than `few` forms
    /// are left each is looked at by itself, and no item is a group.
    void operator()(const Rectangle& r, std::span<const Item> items, std::size_t few,
                    std::vector<Item>& kept);

    /// Calls keep(i) for the items that FormCulling keeps. Pre: no item is a group.
    template <class Keep>
    void keep_forms(const Rectangle& r, std::span<const Item> items, Keep&& keep) {
        one_by_one_(
            r, items, [this](Item item) -> const Form& { return (*forms_)[item]; }, keep);
    }

private:
    static bool is_above(const Group& group, const BoxForm& rival, const FormCulling::Middle& at);
    bool hide_much(std::span<const Item> items, const BoxForm& rival, const FormCulling::Middle& at) const;

    const CompetingForms* forms_;
    FormCulling one_by_one_;
    std::vector<Item> open_;
    std::vector<BoxForm> box_forms_;
};

}  // namespace vcell
