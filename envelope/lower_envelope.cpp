// The recursion of [HE, section 2.1] with the region split before the forms are: over a small piece of the
// region only the forms that are lowest somewhere in it matter, whatever their total number, and there the
// diagrams are merged. The pieces' diagrams are glued along the seams (patchwork.hpp).
//
// Within a piece the recursion splits off one form at a time as long as there are few: the diagram of one
// form is a single face, so its overlay with the rest is the rest itself, and no crossing of unrelated
// trisectors is ever computed. A piece whose forms cannot be culled (many meeting at one vertex, say) is
// halved and merged by overlay, which keeps the worst case at O(n log n) overlays of what is there.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "../core/errors.hpp"
#include "minimization_diagram.hpp"
#include "patchwork.hpp"
#include "work_diagram.hpp"

namespace vcell {

namespace {

using Form = CircleKernel::Form;
using Jet = CircleKernel::Jet;

// Measured on random scenes (bench_envelope): pieces of fewer candidates spend more on seams, larger ones more
// on comparing faces with forms that lose there.
constexpr std::size_t piece_candidates = 64;
constexpr std::size_t quartering_candidates = 16;
// Splitting on although the candidates hardly get fewer: this often in a row, then the piece is taken as it is.
constexpr int most_stalled_splits = 8;
// Off the middle, by no fraction that input favours: a seam through a lattice's vertices would be legal but slow.
constexpr double split_ratio = 0.48643;

struct Rect {
    double x0, x1, y0, y1;
};

// A convex piece of the region and the rectangle around it.
struct Piece {
    std::vector<PieceSide> sides;
    std::vector<std::array<Interval, 2>> corners;  // corner i: start of side i
    Rect rect;
};

std::array<Interval, 2> corner_of(const PieceSide& s, const PieceSide& t) {
    const Interval det = Interval(s.a) * Interval(t.b) - Interval(s.b) * Interval(t.a);
    return {(Interval(s.b) * Interval(t.c) - Interval(t.b) * Interval(s.c)) / det,
            (Interval(s.c) * Interval(t.a) - Interval(t.c) * Interval(s.a)) / det};
}

Piece make_piece(std::vector<PieceSide> sides) {
    Piece p;
    constexpr double inf = std::numeric_limits<double>::infinity();
    p.rect = {inf, -inf, inf, -inf};
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const auto c = corner_of(sides[(i + sides.size() - 1) % sides.size()], sides[i]);
        p.corners.push_back(c);
        p.rect.x0 = std::min(p.rect.x0, c[0].lower());
        p.rect.x1 = std::max(p.rect.x1, c[0].upper());
        p.rect.y0 = std::min(p.rect.y0, c[1].lower());
        p.rect.y1 = std::max(p.rect.y1, c[1].upper());
    }
    p.sides = std::move(sides);
    return p;
}

class EnvelopeBuilder {
public:
    EnvelopeBuilder(const FormFamily& family, const ConvexRegion& region, const EnvelopeOptions& options)
        : family_(family), region_(region), options_(options), patchwork_(family, region), work_(kernel_) {
        forms_.reserve(family.forms.size());
        for (const CircularForm& f : family.forms) forms_.push_back(CircleKernel::make_form(f));
    }

    MinimizationDiagram build() {
        std::vector<PieceSide> sides;
        for (std::uint32_t i = 0; i < region_.sides.size(); ++i)
            sides.push_back({region_.sides[i].a, region_.sides[i].b, region_.sides[i].c, i});
        std::vector<FormId> all(forms_.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = FormId{i};
        solve(make_piece(std::move(sides)), all, 1.0, 0);
        MinimizationDiagram result = patchwork_.finish();
        result.decisions = kernel_.decisions();
        return result;
    }

private:
    // Keeps the candidates that may be lowest somewhere in the rectangle: those that are not certainly above a
    // rival all over it. The best rival is the one whose highest value in the rectangle is lowest.
    template <class Keep>
    void cull(const Rect& r, std::span<const FormId> candidates, Keep&& keep) {
        const double x = 0.5 * r.x0 + 0.5 * r.x1, y = 0.5 * r.y0 + 0.5 * r.y1;
        const double rx = Interval::up(std::max(r.x1 - x, x - r.x0)), ry = Interval::up(std::max(r.y1 - y, y - r.y0));
        places_.resize(candidates.size());
        std::size_t rival = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            places_[i] = CircleKernel::place(forms_[candidates[i]], x, y, rx, ry);
            if (places_[i].top < places_[rival].top) rival = i;
        }
        for (std::size_t i = 0; i < candidates.size(); ++i)
            if (!CircleKernel::certainly_above(places_[i], places_[rival], rx, ry)) keep(i);
    }

    // Looks closer before the merging starts: a form must hold out in one of four quarters.
    void cull_in_quarters(const Rect& r, std::vector<FormId>& candidates) {
        const double x = r.x0 + 0.5 * (r.x1 - r.x0), y = r.y0 + 0.5 * (r.y1 - r.y0);
        kept_.assign(candidates.size(), false);
        for (const Rect& quarter : {Rect{r.x0, x, r.y0, y}, Rect{x, r.x1, r.y0, y}, Rect{r.x0, x, y, r.y1}, Rect{x, r.x1, y, r.y1}})
            cull(quarter, candidates, [&](std::size_t i) { kept_[i] = true; });
        std::size_t count = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i)
            if (kept_[i]) candidates[count++] = candidates[i];
        candidates.resize(count);
    }

    // Returns the handle of the piece's diagram in the patchwork.
    Patchwork::Index solve(const Piece& piece, std::span<const FormId> inherited, double share, int stalled) {
        std::vector<FormId> candidates;
        cull(piece.rect, inherited, [&](std::size_t i) { candidates.push_back(inherited[i]); });
        stalled = 8 * candidates.size() > 7 * inherited.size() ? stalled + 1 : 0;
        if (candidates.size() > piece_candidates && stalled <= most_stalled_splits) {
            if (const auto halves = split(piece)) {
                const Patchwork::Index a = solve(halves->first, candidates, share * split_ratio, stalled);
                const Patchwork::Index b = solve(halves->second, candidates, share * (1 - split_ratio), stalled);
                return patchwork_.glue(a, b, halves->seam);
            }
        }
        return conquer(piece, candidates, share);
    }

    struct Halves {
        Piece first, second;
        std::uint32_t seam;
    };

    // Cuts across the longer side. The seam must avoid the corners, certainly: a few places are tried.
    std::optional<Halves> split(const Piece& piece) {
        const Rect& r = piece.rect;
        const bool upright = r.x1 - r.x0 >= r.y1 - r.y0;
        const double lo = upright ? r.x0 : r.y0, hi = upright ? r.x1 : r.y1;
        const std::size_t n = piece.sides.size();
        for (const double shift : {0.0, 0.03, -0.03, 0.07, -0.07}) {
            const double at = lo + (split_ratio + shift) * (hi - lo);
            std::vector<bool> beyond(n);
            bool clear = at > lo && at < hi;
            for (std::size_t i = 0; i < n && clear; ++i) {
                const Interval& c = piece.corners[i][upright ? 0 : 1];
                clear = !c.contains(at);
                beyond[i] = c.lower() > at;
            }
            if (!clear) continue;
            const double a = upright ? 1 : 0, b = upright ? 0 : 1;
            const std::uint32_t seam = patchwork_.new_seam(a, b, -at);
            std::vector<PieceSide> first, second;
            for (std::size_t i = 0; i < n; ++i) {
                const bool from = beyond[i], to = beyond[(i + 1) % n];
                if (!from || !to) first.push_back(piece.sides[i]);
                if (from || to) second.push_back(piece.sides[i]);
                if (!from && to) first.push_back({-a, -b, at, seam});
                if (from && !to) second.push_back({a, b, -at, seam});
            }
            Halves halves{make_piece(std::move(first)), make_piece(std::move(second)), seam};
            // The first piece is to lie left of the upright seam; a level one is turned by a right angle.
            if (!upright) std::swap(halves.first, halves.second);
            return halves;
        }
        return std::nullopt;
    }

    Patchwork::Index conquer(const Piece& piece, std::vector<FormId>& candidates, double share) {
        const double x = 0.5 * piece.rect.x0 + 0.5 * piece.rect.x1, y = 0.5 * piece.rect.y0 + 0.5 * piece.rect.y1;
        if (candidates.size() > quartering_candidates) cull_in_quarters(piece.rect, candidates);
        // Low ones first: most of the others then lose at once.
        order_.clear();
        for (const FormId f : candidates) order_.emplace_back(CircleKernel::jet(forms_[f], x, y).v, f);
        std::ranges::sort(order_);
        kernel_.reset(&family_);
        lines_.clear();
        for (const PieceSide& s : piece.sides) lines_.push_back(kernel_.add_line(s.a, s.b, s.c));
        std::vector<FormId> forms;
        for (const auto& [height, f] : order_) forms.push_back(kernel_.add_form(f));
        merge_all(work_, forms, piece.rect);
        const Patchwork::Index handle = patchwork_.add(work_, piece.sides);
        done_ += share;
        if (options_.progress) options_.progress(done_);
        return handle;
    }

    // The diagram of these forms of the kernel, low ones first, over the polygon lines_.
    void merge_all(WorkDiagram& work, std::span<FormId> forms, const Rect& r) {
        if (forms.size() <= std::max<std::size_t>(options_.largest_piece, 1)) {
            work.start(lines_, forms[0]);
            for (const FormId f : forms.subspan(1)) work.insert(f);
            return;
        }
        // Forms that are lowest in different places share few faces: halve along the longer side.
        const bool wide = r.x1 - r.x0 >= r.y1 - r.y0;
        const auto place = [&](FormId f) {
            const Form& form = kernel_.form(f);
            if (form.k != 0) return wide ? form.cx : form.cy;
            const bool falls = (wide ? form.a : form.b) < 0;
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
    }

    const FormFamily& family_;
    const ConvexRegion& region_;
    const EnvelopeOptions& options_;
    IdVector<FormId, Form> forms_;
    CircleKernel kernel_;
    Patchwork patchwork_;
    WorkDiagram work_;
    double done_ = 0;
    // Working space.
    std::vector<CircleKernel::Place> places_;
    std::vector<char> kept_;
    std::vector<std::pair<double, FormId>> order_;
    std::vector<FormId> lines_;
};

}  // namespace

MinimizationDiagram lower_envelope(const FormFamily& family, const ConvexRegion& region, const EnvelopeOptions& options) {
    if (family.forms.empty()) {
        // Any one form makes the region's face; then its label is taken away.
        FormFamily constant;
        constant.forms.push_back({});
        constant.exact = [](FormId) { return ExactForm{{}, {}, {}, {}, Exact(1.0)}; };
        MinimizationDiagram out = EnvelopeBuilder(constant, region, options).build();
        out.clear_labels();
        return out;
    }
    return EnvelopeBuilder(family, region, options).build();
}

FormId lowest_form(const FormFamily& family, double x, double y) {
    // Evaluate in double with bounds; compare what overlaps exactly.
    FormId best;
    Jet best_jet{};
    for (const FormId f : family.forms.ids()) {
        const Jet j = CircleKernel::jet(CircleKernel::make_form(family.forms[f]), x, y);
        if (best.valid() && j.v - j.ev > best_jet.v + best_jet.ev) continue;
        bool lower = !best.valid() || j.v + j.ev < best_jet.v - best_jet.ev;
        if (!lower) {
            const ExactForm p = family.exact(f), q = family.exact(best);
            const Exact ex(x), ey(y), s = ex * ex + ey * ey;
            const Exact fp = p.K * s + p.A * ex + p.B * ey + p.C, fq = q.K * s + q.A * ex + q.B * ey + q.C;
            lower = (fp * q.W - fq * p.W).sign() == Sign::Negative;
        }
        if (lower) {
            best = f;
            best_jet = j;
        }
    }
    return best;
}

}  // namespace vcell
