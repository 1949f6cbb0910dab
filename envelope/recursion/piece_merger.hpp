/// The diagram of circular forms over one piece of the region: candidates that lose everywhere are left out,
/// the others inserted one after the other, and where they are many the diagrams of halves of them merged by
/// overlay.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../circles/work_diagram.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "competing_forms.hpp"
#include "pieces.hpp"

namespace vcell {

class PieceMerger {
    using Form = CircleKernel::Form;
    using Item = CompetingForms::Item;
    struct Competitor {
        double height;
        FormId id;
        Item item;
        auto operator<=>(const Competitor&) const = default;
    };

public:
    /// The family and the options must outlive this object.
    PieceMerger(const FormFamily& family, const EnvelopeOptions& options)
        : family_(family),
          options_(options),
          largest_(options.largest_piece),
          work_(kernel_),
          floor_(kernel_),
          lesser_(kernel_) {}
    PieceMerger(const PieceMerger&) = delete;
    PieceMerger& operator=(const PieceMerger&) = delete;

    const Decisions& decisions() const { return kernel_.decisions(); }
    /// Insertions and merges so far.
    const EnvelopeWork& effort() const { return effort_; }

    /// The diagram of the candidates over the piece, if these are all that may be lowest in it; valid until
    /// the next call. More candidates than `quartering` are culled before.
    const WorkDiagram& merge(const RegionPiece& piece, CompetingForms::Culling& cull,
                             std::vector<Item>& candidates, std::size_t quartering) {
        const double x = 0.5 * piece.rect.x0 + 0.5 * piece.rect.x1,
                     y = 0.5 * piece.rect.y0 + 0.5 * piece.rect.y1;
        if (candidates.size() > quartering) cull_in_quarters(piece.rect, cull, candidates);
        // Low ones first: most of the others then lose at once.
        order_.clear();
        const CompetingForms& all = cull.forms();
        for (const Item i : candidates) order_.push_back({CircleKernel::jet(all[i], x, y).v, all.id(i), i});
        std::ranges::sort(order_);
        kernel_.reset(&family_);
        lines_.clear();
        for (const PieceSide& s : piece.sides) lines_.push_back(kernel_.add_line(s.a, s.b, s.c));
        std::vector<FormId> forms;
        for (const Competitor& c : order_) forms.push_back(kernel_.add_form(c.id, all[c.item]));
        work_.set_floor({}, false);
        merge_all(work_, forms, piece.rect);
        return options_.floor.empty() ? work_ : merge_floor();
    }

private:
    // Looks closer before the merging starts: a form must hold out in one of four quarters.
    void cull_in_quarters(const Rectangle& r, CompetingForms::Culling& cull, std::vector<Item>& candidates) {
        const double x = r.x0 + 0.5 * (r.x1 - r.x0), y = r.y0 + 0.5 * (r.y1 - r.y0);
        kept_.assign(candidates.size(), false);
        for (const Rectangle& quarter : {Rectangle{r.x0, x, r.y0, y}, Rectangle{x, r.x1, r.y0, y},
                                         Rectangle{r.x0, x, y, r.y1}, Rectangle{x, r.x1, y, r.y1}})
            cull.keep_forms(quarter, candidates, [&](std::size_t i) { kept_[i] = true; });
        std::size_t count = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i)
            if (kept_[i]) candidates[count++] = candidates[i];
        candidates.resize(count);
    }

    // The diagram of work_ and the floor. Its forms come last in the kernel.
    const WorkDiagram& merge_floor() {
        std::vector<FormId> floor;
        for (const FormId f : options_.floor) floor.push_back(kernel_.add_form(f));
        effort_.insertions += floor.size();
        for (WorkDiagram* diagram : {&work_, &floor_, &lesser_})
            diagram->set_floor(floor.front(), options_.is_below_floor);
        if (!options_.is_below_floor) {
            for (const FormId f : floor) work_.insert(f);
            return work_;
        }
        floor_.start(lines_, floor.front());
        for (const FormId f : std::span(floor).subspan(1)) floor_.insert(f);
        lesser_.merge(work_, floor_);
        return lesser_;
    }

    // The diagram of these forms of the kernel, low ones first, over the polygon lines_.
    void merge_all(WorkDiagram& work, std::span<FormId> forms, const Rectangle& r) {
        if (forms.size() <= std::max<std::size_t>(largest_, 1)) {
            work.start(lines_, forms[0]);
            for (const FormId f : forms.subspan(1)) work.insert(f);
            effort_.insertions += forms.size() - 1;
            return;
        }
        // Forms that are lowest in different places share few faces: halve along the longer side.
        const bool wide = r.x1 - r.x0 >= r.y1 - r.y0;
        const auto place = [&](FormId f) {
            const Form& form = kernel_.form(f);
            const double slope = wide ? form.a : form.b;
            if (form.k != 0) return (wide ? form.cx : form.cy) - 0.5 * slope / form.k;
            const bool falls = slope < 0;
            return wide ? (falls ? r.x1 : r.x0) : (falls ? r.y1 : r.y0);
        };
        std::vector<FormId> sorted(forms.begin(), forms.end());
        const std::size_t half = forms.size() / 2;
        std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(half), {}, place);
        // Their numbers ascend with their heights.
        std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(half));
        std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(half), sorted.end());
        WorkDiagram first(kernel_), second(kernel_);
        merge_all(first, std::span(sorted).first(half), r);
        merge_all(second, std::span(sorted).subspan(half), r);
        work.merge(first, second);
        ++effort_.merges;
    }

    const FormFamily& family_;
    const EnvelopeOptions& options_;
    const std::size_t largest_;
    CircleKernel kernel_;
    WorkDiagram work_, floor_, lesser_;
    EnvelopeWork effort_;
    // Working space.
    std::vector<char> kept_;
    std::vector<Competitor> order_;
    std::vector<FormId> lines_;
};

}  // namespace vcell
