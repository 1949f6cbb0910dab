/// Which circular forms may be lowest somewhere in a rectangle.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "pieces.hpp"

namespace vcell {

/// Copies share the forms, so that each thread may cull with one.
class CircularCulling {
    using Forms = IdVector<FormId, CircleKernel::Form>;

public:
    explicit CircularCulling(const CircularFamily& family) {
        Forms forms;
        forms.reserve(family.forms.size());
        for (const CircularForm& f : family.forms) forms.push_back(CircleKernel::make_form(f));
        forms_ = std::make_shared<const Forms>(std::move(forms));
    }

    const CircleKernel::Form& operator[](FormId f) const { return (*forms_)[f]; }

    /// Keeps the candidates that may be lowest somewhere in the rectangle: calls keep(i) for those that are
    /// not certainly above a rival all over it. The best rival is the one whose highest value in the
    /// rectangle is lowest.
    template <class Keep>
    void operator()(const Rectangle& r, std::span<const FormId> candidates, Keep&& keep) {
        const double x = 0.5 * r.x0 + 0.5 * r.x1, y = 0.5 * r.y0 + 0.5 * r.y1;
        const double rx = Interval::up(std::max(r.x1 - x, x - r.x0)),
                     ry = Interval::up(std::max(r.y1 - y, y - r.y0));
        box_forms_.resize(candidates.size());
        std::size_t rival = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            box_forms_[i] = CircleKernel::box_form((*forms_)[candidates[i]], x, y, rx, ry);
            if (box_forms_[i].top < box_forms_[rival].top) rival = i;
        }
        for (std::size_t i = 0; i < candidates.size(); ++i)
            if (!CircleKernel::certainly_above(box_forms_[i], box_forms_[rival], rx, ry)) keep(i);
    }

private:
    std::shared_ptr<const Forms> forms_;
    std::vector<CircleKernel::BoxForm> box_forms_;  // working space
};

}  // namespace vcell
