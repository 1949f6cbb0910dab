/// The diagram of circular forms over one piece of the region: candidates that lose everywhere are left out,
/// the others inserted one after the other, by walking where they are many. Where that will not do the
/// diagrams of halves of them are merged by overlay.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../circles/vertex_grid.hpp"
#include "../circles/work_diagram.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "ceiling.hpp"
#include "competing_forms.hpp"
#include "pieces.hpp"

namespace vcell {

class PieceMerger {
    using Form = KernelForm;
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

    /// merge() of more candidates than are compared with one another well: each is inserted where walking
    /// leads to, in the order of K (WorkDiagram::insert_most_curved()). Null where that is not for these
    /// candidates, of which those that are certainly hidden are left out.
    const WorkDiagram* merge_by_walking(const RegionPiece& piece, const CompetingForms& all,
                                        std::vector<Item>& candidates) {
        if (!options_.floor.empty()) return nullptr;
        leave_out_hidden(piece.rect, all, candidates);
        start(piece);
        in_order_.clear();
        for (const Item i : candidates)
            in_order_.push_back({all[i].K, 0, kernel_.add_form(all.id(i), all[i])});
        put_in_order_of_curvature(piece.rect);
        // Flat forms come last, sought in all faces: at first they would be one face around islands that
        // others do away with.
        const double usual = in_order_[in_order_.size() / 2].K;
        const auto is_usual = [&](const Placed& p) { return !(p.K < flat_part * usual); };
        const auto first_usual = std::ranges::find_if(in_order_, is_usual);
        const auto flat = static_cast<std::size_t>(first_usual - in_order_.begin());
        if (flat * one_flat_in > in_order_.size()) return nullptr;
        std::ranges::rotate(in_order_, first_usual);

        work_.set_floor({}, false);
        work_.start(lines_, in_order_.front().form);
        const Rectangle& r = piece.rect;
        grid_.start(r.x0, r.x1, r.y0, r.y1, 2 * candidates.size());
        WorkDiagram::Index last = 0;
        std::size_t room = first_insertions * visits_of_insertion;
        for (std::size_t i = 1; i < in_order_.size(); ++i) {
            room += visits_of_insertion;
            if (work_.visit_count() > room || work_.is_holey()) return nullptr;
            const FormId form = in_order_[i].form;
            if (i + flat >= in_order_.size()) {
                work_.insert(form);
                continue;
            }
            const auto [x, y] = place(kernel_.form(form), r);
            WorkDiagram::Index from =
                grid_.find(x, y, [&](WorkDiagram::Index v) { return work_.is_on_way(v); });
            if (from == WorkDiagram::none) from = work_.is_on_way(last) ? last : work_.any_on_way();
            last = work_.insert_most_curved(form, from);
            if (!work_.is_on_way(last)) continue;
            const WorkDiagram::Vertex& v = work_.vertices()[last];
            grid_.put(v.x, v.y, last);
        }
        effort_.insertions += in_order_.size() - 1;
        return &work_;
    }

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
        for (const Item i : candidates) order_.push_back({all[i].jet(x, y).v, all.id(i), i});
        std::ranges::sort(order_);
        start(piece);
        std::vector<FormId> forms;
        for (const Competitor& c : order_) forms.push_back(kernel_.add_form(c.id, all[c.item]));
        work_.set_floor({}, false);
        merge_all(work_, forms, piece.rect);
        return options_.floor.empty() ? work_ : merge_floor();
    }

private:
    // A form of the kernel, and the square of its place's distance from the middle, where that matters.
    struct Placed {
        double K, distance;
        FormId form;
    };
    // A form comes to a hundred half-edges usually. Where many forms meet in one place these are as many as
    // there are forms; then smaller pieces are better.
    static constexpr std::size_t visits_of_insertion = 256, first_insertions = 32;
    // A form is flat if its K is less than this part of what is usual; few are to be so, one in so many.
    static constexpr double flat_part = 0.125;
    static constexpr std::size_t one_flat_in = 8;

    void start(const RegionPiece& piece) {
        kernel_.reset(&family_);
        lines_.clear();
        for (const PieceSide& s : piece.sides) lines_.push_back(kernel_.add_line(s.a, s.b, s.c));
    }

    // Where a form is least in the rectangle, about.
    static std::array<double, 2> place(const Form& f, const Rectangle& r) {
        const auto along = [&](double center, double slope, double low, double high) {
            double at = slope < 0 ? high : low;
            if (f.k > 0) at = slope == 0 ? center : center - 0.5 * slope / f.k;
            return at > low ? std::min(at, high) : low;
        };
        return {along(f.cx, f.a, r.x0, r.x1), along(f.cy, f.b, r.y0, r.y1)};
    }

    // Puts in_order_ into the exact order of K. Forms of one K come from the middle outwards: those of a
    // lattice then hardly tie but where they do in the end.
    void put_in_order_of_curvature(const Rectangle& r) {
        std::ranges::sort(in_order_, {}, &Placed::K);
        constexpr double rounding = 2 * kernel_bounds::K_roundings;
        for (std::size_t begin = 0, end = 0; begin < in_order_.size(); begin = end) {
            const auto is_near = [&](double low, double high) {
                return !(high - low > rounding * (std::abs(low) + std::abs(high)));
            };
            for (end = begin + 1; end < in_order_.size() && is_near(in_order_[end - 1].K, in_order_[end].K);)
                ++end;
            const auto run = std::span(in_order_).subspan(begin, end - begin);
            if (run.size() == 1) continue;
            const auto sign = [&](const Placed& p, const Placed& q) {
                return kernel_.curvature_sign({p.form, q.form});
            };
            if (std::ranges::all_of(run.subspan(1),
                                    [&](const Placed& p) { return sign(run.front(), p) == Sign::Zero; })) {
                for (Placed& p : run) {
                    const auto [x, y] = place(kernel_.form(p.form), r);
                    const double dx = x - 0.5 * r.x0 - 0.5 * r.x1, dy = y - 0.5 * r.y0 - 0.5 * r.y1;
                    p.distance = dx * dx + dy * dy;
                }
                std::ranges::sort(run, {}, [](const Placed& p) { return std::pair(p.distance, p.form); });
            } else {
                std::ranges::sort(
                    run, [&](const Placed& p, const Placed& q) { return sign(p, q) == Sign::Negative; });
            }
        }
    }

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

    // Leaves out what a bound on the envelope shows to be nowhere lowest.
    void leave_out_hidden(const Rectangle& r, const CompetingForms& all, std::vector<Item>& candidates) {
        const auto is_inside = [&](double x, double y) {
            return x > r.x0 && x < r.x1 && y > r.y0 && y < r.y1;
        };
        places_.clear();
        std::size_t inside = 0;
        for (const Item i : candidates) {
            const auto [x, y] = place(all[i], r);
            places_.push_back({x, y, is_inside(x, y)});
            inside += places_.back().is_inside;
        }
        ceiling_.start(r, inside);
        for (std::size_t i = 0; i < candidates.size(); ++i)
            if (const Place& p = places_[i]; p.is_inside) ceiling_.add(all[candidates[i]], p.x, p.y);
        ceiling_.finish();
        std::size_t count = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            const Form& form = all[candidates[i]];
            const Place& p = places_[i];
            const bool is_told = p.is_inside ? ceiling_.is_open(form, p.x, p.y)
                                             : form.k > 0 && ceiling_.is_over_all(form, p.x, p.y);
            if (is_told ? p.is_inside : !ceiling_.hides(form)) candidates[count++] = candidates[i];
        }
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
    std::vector<Placed> in_order_;
    VertexGrid grid_;
    Ceiling ceiling_;
    struct Place {
        double x, y;
        bool is_inside;
    };
    std::vector<Place> places_;
};

}  // namespace vcell
