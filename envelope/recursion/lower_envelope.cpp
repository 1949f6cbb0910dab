// The recursion of [HE, section 2.1] with the region split before the forms are: over a small piece of the
// region only the forms that are lowest somewhere in it matter, whatever their total number, and there the
// diagrams are merged. The pieces' diagrams are glued along the seams (patchwork.hpp).
//
// Within a piece the recursion splits off one form at a time as long as there are few: the diagram of one
// form is a single face, so its overlay with the rest is the rest itself, and no crossing of unrelated
// trisectors is ever computed. A piece whose forms cannot be culled (many meeting at one vertex, say) is
// halved and merged by overlay, which keeps the worst case at O(n log n) overlays of what is there.
//
// Where a cylinder competes the pieces are split until they are plain (mixed_piece.hpp); the labels along
// their sides are found once, when the side is made, so that the pieces beside a seam cannot disagree. Pieces
// without a competing cylinder are left to exact merging.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "../../core/errors.hpp"
#include "../../core/small_vector.hpp"
#include "../circles/work_diagram.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../diagram/patchwork.hpp"
#include "../proofs/mixed_piece.hpp"
#include "../sphere/sphere_diagram.hpp"

namespace vcell {

namespace {

using Form = CircleKernel::Form;
using Jet = CircleKernel::Jet;

// Measured on random scenes (bench_envelope): pieces of fewer candidates spend more on seams, larger ones
// more on comparing faces with forms that lose there.
struct Sizes {
    std::size_t piece;       // candidates that are merged without splitting further
    std::size_t quartering;  // more of them are culled in quarters before
};
constexpr Sizes region_sizes{64, 16}, sphere_sizes{32, 4};
// Splitting on although the candidates hardly get fewer: this often in a row, then the piece is taken as it
// is.
constexpr int most_stalled_splits = 8;
// Pieces with more competitors than this are not plain: looking closer is a waste.
constexpr std::size_t most_competitors = 6;
// More that tie in a point are seen to where pieces are so small that nothing else is left in them.
constexpr std::size_t most_tied = 8;
// A tube's circumference, 4, is cut into such parts as long as there are more competitors than this.
constexpr std::size_t most_around = 32;
constexpr double part_around = 0.3;
// Where differences of three competitors or more change so much more along one axis pieces are cut across
// that, unless they are too slender.
constexpr double much_steeper = 4, most_slender = 0x1p16;
// A vertex needs some hundred pieces below this part of the region at worst, and a form has two vertices on
// average. Many more of them in all, or within one piece of that size, follow a curve along which forms tie
// without crossing: no number of pieces decides that.
constexpr double small_part = 0x1p-16;
constexpr std::size_t most_small_pieces_in_place = 5000, small_pieces_of_form = 200;
// Pieces of any size are split fewer than 50 times to a form usually, 200 times where few forms have much to
// do with each other, 80,000 times in all along a line that hardly leaves a plane; forms that all but
// coincide want it as often as the square of the region's size over their distance.
constexpr std::size_t most_splits = 80000, splits_of_form = 250;
// Off the middle, by no fraction that input favours: a seam through a lattice's vertices would be legal but
// slow.
constexpr double split_ratio = 0.48643;

struct Rect {
    double x0, x1, y0, y1;
};

constexpr std::size_t usual_sides = 6;
using Sides = SmallVector<PieceSide, usual_sides>;

// A convex piece of the region and the rectangle around it.
struct Piece {
    Sides sides;
    SmallVector<IntervalPoint, usual_sides> corners;  // corner i: start of side i
    Rect rect;
};

// A piece in which cylinders compete: what is lowest along its sides is known.
struct LabelledPiece {
    Piece piece;
    std::vector<SideLabels> labels;
    std::vector<std::vector<FormId>> corner_ties;
};

Piece make_piece(Sides sides) {
    Piece p;
    p.corners.reserve(sides.size());
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
        : family_(family),
          region_(region),
          options_(options),
          patchwork_(family),
          work_(kernel_),
          root_(make_piece(sides_of(region))),
          analysis_(family, extent(root_.rect)) {
        forms_.reserve(family.forms.size());
        for (const CircularForm& f : family.forms) forms_.push_back(CircleKernel::make_form(f));
    }

    MinimizationDiagram over_region() {
        solve_all(root_, 1.0);
        return finish();
    }

    // Pre: the region's rim, and all beyond it, belongs to one form.
    MinimizationDiagram over_sphere() {
        is_sphere_ = true;
        sizes_ = sphere_sizes;
        patchwork_.drop_rim(solve_all(root_, 1.0));
        MinimizationDiagram result = finish();
        result.region = {};
        return result;
    }

    // The region is [-1, 3] x [y0, y1] of half-angle coordinates; both halves are smooth pieces, and together
    // they close. The seams are labelled once.
    MinimizationDiagram over_cylinder() {
        is_cylinder_ = true;
        const double y0 = root_.rect.y0, y1 = root_.rect.y1;
        const std::uint32_t middle = patchwork_.new_seam(), left = patchwork_.new_seam(),
                            right = patchwork_.new_seam();
        const PieceSide bottom{0, 1, -y0, 0}, top{0, -1, y1, 2};
        LabelledPiece front = label(make_piece({bottom, {-1, 0, 1, middle}, top, {1, 0, 1, left}})),
                      back = label(make_piece({bottom, {-1, 0, 3, right}, top, {1, 0, -1, middle}}));
        back.labels[3] = front.labels[1].reversed();
        back.labels[1] = front.labels[3].reversed();
        for (RimTransition& t : back.labels[1].transitions) t.point.x() += circumference;
        const Patchwork::Index all = patchwork_.glue(solve_labelled(front, all_forms(), 0.5),
                                                     solve_labelled(back, all_forms(), 0.5), middle);
        patchwork_.close(all, right, left, circumference, top.id);
        return finish();
    }

    static constexpr double circumference = MixedAnalysis::circumference;

private:
    std::vector<FormId> all_forms() const {
        std::vector<FormId> all(family_.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = FormId{i};
        return all;
    }

    Patchwork::Index solve_all(const Piece& piece, double share) {
        if (family_.is_all_circular()) return solve(piece, all_forms(), share, 0);
        return solve_labelled(label(piece), all_forms(), share);
    }

    MinimizationDiagram finish() {
        MinimizationDiagram result = patchwork_.finish(analysis_.heights());
        result.region = region_;
        result.decisions = kernel_.decisions();
        result.decisions += analysis_.decisions();
        result.assumptions = std::move(analysis_.assumptions());
        return result;
    }

    static Sides sides_of(const ConvexRegion& region) {
        Sides sides;
        for (std::uint32_t i = 0; i < region.sides.size(); ++i)
            sides.push_back({region.sides[i].a, region.sides[i].b, region.sides[i].c, i});
        return sides;
    }
    static double extent(const Rect& r) { return std::max(r.x1 - r.x0, r.y1 - r.y0); }

    // Keeps the candidates that may be lowest somewhere in the rectangle: those that are not certainly above
    // a rival all over it. The best rival is the one whose highest value in the rectangle is lowest.
    template <class Keep>
    void cull(const Rect& r, std::span<const FormId> candidates, Keep&& keep) {
        const double x = 0.5 * r.x0 + 0.5 * r.x1, y = 0.5 * r.y0 + 0.5 * r.y1;
        const double rx = Interval::up(std::max(r.x1 - x, x - r.x0)),
                     ry = Interval::up(std::max(r.y1 - y, y - r.y0));
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
        for (const Rect& quarter :
             {Rect{r.x0, x, r.y0, y}, Rect{x, r.x1, r.y0, y}, Rect{r.x0, x, y, r.y1}, Rect{x, r.x1, y, r.y1}})
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
        if (candidates.size() > sizes_.piece && stalled <= most_stalled_splits) {
            if (const auto halves = split(piece)) {
                const Patchwork::Index a = solve(halves->first, candidates, share * split_ratio, stalled);
                const Patchwork::Index b =
                    solve(halves->second, candidates, share * (1 - split_ratio), stalled);
                return patchwork_.glue(a, b, halves->seam);
            }
        }
        return conquer(piece, candidates, share);
    }

    struct Halves {
        Piece first, second;
        std::uint32_t seam;
    };

    // A line across a piece: x = at (upright) or y = at. `beyond` tells on which side each corner lies.
    struct Cut {
        bool upright;
        double at;
        SmallVector<bool, usual_sides> beyond;

        PieceSide side() const { return {upright ? 1.0 : 0.0, upright ? 0.0 : 1.0, -at, UINT32_MAX}; }
        PieceSide opposite() const { return {upright ? -1.0 : -0.0, upright ? -0.0 : -1.0, at, UINT32_MAX}; }
    };

    // Half-way in the metric of the base: over a sphere dx / (1 + x^2 + y^2) at the y where it is widest.
    struct Lengths {
        double a;  // 0: over a plane

        double at(double x) const { return a > 0 ? std::atan(x / a) / a : x; }
        double inverse(double length) const { return a > 0 ? a * std::tan(a * length) : length; }
    };
    // Over a cylinder y is measured by its distance from a tip: as that shrinks, so does what there is along
    // the axis.
    struct AxialLengths {
        const AxialTips& tips;
        double scale;  // of y about the middle of the region

        double at(double y) const {
            double length = tips.any() ? 0 : y;
            if (const auto& tip = tips[AxialEnd::Low]) length += scale * std::log(y - *tip);
            if (const auto& tip = tips[AxialEnd::High]) length -= scale * std::log(*tip - y);
            return length;
        }
        double inverse(double length) const {
            if (!tips.any()) return length;
            const auto &low = tips[AxialEnd::Low], &high = tips[AxialEnd::High];
            const double ratio = std::exp(length / scale);
            if (!high) return *low + ratio;
            if (!low) return *high - 1 / ratio;
            return *high - (*high - *low) / (1 + ratio);
        }
    };
    Lengths lengths(double y0, double y1) const {
        if (!is_sphere_) return {0};
        const double y = std::max({0.0, y0, -y1});
        return {std::sqrt(1 + y * y)};
    }

    // Across the longer side or, where `upright` says so, the one given; certainly clear of all corners.
    std::optional<Cut> cut_at(const Piece& piece, double shift, std::optional<bool> upright = {}) const {
        const Rect& r = piece.rect;
        Cut cut;
        cut.beyond.reserve(piece.corners.size());
        double lo = 0, hi = 0;
        const auto choose = [&](const auto& along_x, const auto& along_y) {
            cut.upright =
                upright.value_or(along_x.at(r.x1) - along_x.at(r.x0) >= along_y.at(r.y1) - along_y.at(r.y0));
            lo = cut.upright ? r.x0 : r.y0;
            hi = cut.upright ? r.x1 : r.y1;
            const auto divide = [&](const auto& along) {
                const double start = along.at(lo);
                return along.inverse(start + (split_ratio + shift) * (along.at(hi) - start));
            };
            cut.at = cut.upright ? divide(along_x) : divide(along_y);
        };
        if (const AxialTips& tips = family_.tips; tips.any())
            choose(Lengths{0}, AxialLengths{tips, tips.reach / (tips.y[0] && tips.y[1] ? 4 : 2)});
        else
            choose(lengths(r.y0, r.y1), lengths(r.x0, r.x1));
        bool clear = cut.at > lo && cut.at < hi;
        for (const IntervalPoint& corner : piece.corners) {
            const Interval& c = corner[cut.upright ? 0 : 1];
            clear = clear && !c.contains(cut.at);
            cut.beyond.push_back(c.lower() > cut.at);
        }
        return clear ? std::optional(std::move(cut)) : std::nullopt;
    }

    std::optional<Halves> split(const Piece& piece) {
        const std::size_t n = piece.sides.size();
        for (const double shift : {0.0, 0.03, -0.03, 0.07, -0.07}) {
            const auto cut = cut_at(piece, shift);
            if (!cut) continue;
            PieceSide side = cut->side(), opposite = cut->opposite();
            side.id = opposite.id = patchwork_.new_seam();
            Sides first, second;
            for (std::size_t i = 0; i < n; ++i) {
                const bool from = cut->beyond[i], to = cut->beyond[(i + 1) % n];
                if (!from || !to) first.push_back(piece.sides[i]);
                if (from || to) second.push_back(piece.sides[i]);
                if (!from && to) first.push_back(opposite);
                if (from && !to) second.push_back(side);
            }
            Halves halves{make_piece(std::move(first)), make_piece(std::move(second)), side.id};
            // The first piece is to lie left of the upright seam; a level one is turned by a right angle.
            if (!cut->upright) std::swap(halves.first, halves.second);
            return halves;
        }
        return std::nullopt;
    }

    // --- Pieces in which cylinders compete. ---------------------------------------------------------------

    LabelledPiece label(const Piece& piece) {
        const Rect& r = piece.rect;
        const std::vector<FormId> candidates = analysis_.cull({r.x0, r.x1, r.y0, r.y1}, all_forms());
        const std::size_t n = piece.sides.size();
        LabelledPiece out{piece, {}, {}};
        std::vector<FormId> first(n), last(n);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t before = (i + n - 1) % n;
            std::vector<FormId> ties = analysis_.lowest_at(piece.sides[before], piece.sides[i], candidates);
            first[i] = last[before] = ties.front();
            if (ties.size() == 1) {
                ties.clear();
            } else {
                first[i] = analysis_.label_beside(piece.sides[i], piece.corners[i],
                                                  piece.corners[(i + 1) % n], ties);
                last[before] = analysis_.label_beside(piece.sides[before], piece.corners[i],
                                                      piece.corners[before], ties);
            }
            out.corner_ties.push_back(std::move(ties));
        }
        for (std::size_t i = 0; i < n; ++i) {
            auto labels =
                analysis_.label_side(piece.sides[i], piece.corners[i], piece.corners[(i + 1) % n], first[i],
                                     last[i], candidates, Patchwork::is_seam(piece.sides[i].id));
            if (!labels) throw TieError(analysis_.obstacle().value_or(all_of(r, candidates)));
            out.labels.push_back(*std::move(labels));
        }
        return out;
    }

    Patchwork::Index solve_labelled(const LabelledPiece& part, std::span<const FormId> inherited,
                                    double share) {
        const Rect& r = part.piece.rect;
        std::vector<FormId> candidates = analysis_.cull({r.x0, r.x1, r.y0, r.y1}, inherited);
        if (std::ranges::all_of(candidates, [&](FormId f) { return family_.is_circular(f); }))
            return solve(part.piece, candidates, share, 0);
        const double size = extent(r) / analysis_.extent_at({r.x0, r.x1}, {r.y0, r.y1});
        const bool at_floor = size <= MixedAnalysis::floor_width,
                   is_small = extent(r) <=
                              MixedAnalysis::tie_width * analysis_.tie_extent_at({r.x0, r.x1}, {r.y0, r.y1});
        if (candidates.size() <= most_competitors || (is_small && candidates.size() <= most_tied) ||
            size <= MixedAnalysis::node_width) {
            if (const auto resolved = analysis_.resolve(
                    {part.piece.sides, part.piece.corners, part.labels, part.corner_ties})) {
                done_ += share;
                if (options_.progress) options_.progress(done_);
                return patchwork_.add(*resolved);
            }
        }
        if (size >= small_part) {
            small_pieces_in_place_ = 0;  // those of the places before are done
        } else {
            ++small_pieces_;
            ++small_pieces_in_place_;
        }
        splits_ += family_.radial.empty() ? 1 : 4;  // over a curved base a piece costs four times as much
        if (at_floor || splits_ > most_splits + splits_of_form * family_.size() || analysis_.is_spent() ||
            small_pieces_ > small_pieces_of_form * family_.size() ||
            small_pieces_in_place_ > most_small_pieces_in_place)
            throw TieError(all_of(r, candidates));
        const auto halves = split_labelled(part, candidates);
        if (!halves) throw TieError(analysis_.obstacle().value_or(all_of(r, candidates)));
        const Patchwork::Index a = solve_labelled(halves->first, candidates, 0.5 * share);
        const Patchwork::Index b = solve_labelled(halves->second, candidates, 0.5 * share);
        return patchwork_.glue(a, b, halves->seam);
    }

    static Assumption all_of(const Rect& r, std::vector<FormId> forms) {
        std::ranges::sort(forms);
        return {{0.5 * r.x0 + 0.5 * r.x1, 0.5 * r.y0 + 0.5 * r.y1}, extent(r), std::move(forms)};
    }

    struct LabelledHalves {
        LabelledPiece first, second;
        std::uint32_t seam;
    };

    // Which way to cut other than across the longer side. Beside a tip no one metric suits all differences,
    // and where they change along one axis only, as between tubes along a tube, pieces are to be as long as
    // these. Seen from half of a tube's circumference no object is nearest all around: none is culled.
    std::optional<bool> cut_upright(const Rect& r, std::size_t candidates) const {
        if (family_.chart == RadialChart::HalfAngle && candidates > most_around && r.x1 - r.x0 > part_around)
            return true;
        // No one metric suits tubes that are all but parallel to the base.
        constexpr double strip_part = 0x1p-4;
        if (is_cylinder_ && extent(r) < strip_part * extent(root_.rect))
            if (const auto upright = analysis_.asks_for_strips({r.x0, r.x1, r.y0, r.y1})) return upright;
        const auto steepness = analysis_.steepness_across(r.x1 - r.x0, r.y1 - r.y0);
        if (!steepness) return std::nullopt;
        if (family_.tips.any()) return *steepness >= 1;
        const double x = r.x1 - r.x0, y = r.y1 - r.y0;
        if (candidates < 3 || std::max(x, y) > most_slender * std::min(x, y)) return std::nullopt;
        if (*steepness >= much_steeper) return true;
        if (*steepness * much_steeper <= 1) return false;
        return std::nullopt;
    }

    std::optional<LabelledHalves> split_labelled(const LabelledPiece& part,
                                                 const std::vector<FormId>& candidates) {
        const Piece& piece = part.piece;
        const std::size_t n = piece.sides.size();
        const auto upright = cut_upright(piece.rect, candidates.size());
        for (const double shift : {0.0, 0.03, -0.03, 0.07, -0.07, 0.11, -0.11, 0.17, -0.17}) {
            const auto cut = cut_at(piece, shift, upright);
            if (!cut) continue;
            LabelledHalves halves;
            for (LabelledPiece* half : {&halves.first, &halves.second}) {
                half->piece.sides.reserve(n + 1);
                half->labels.reserve(n + 1);
                half->corner_ties.reserve(n + 1);
            }
            const auto push = [](LabelledPiece& to, const PieceSide& side, SideLabels labels,
                                 std::vector<FormId> ties) {
                to.piece.sides.push_back(side);
                to.labels.push_back(std::move(labels));
                to.corner_ties.push_back(std::move(ties));
            };
            // Where the seam leaves the first half's sides and where it returns to them.
            std::optional<std::size_t> leaving, returning;
            FormId at_leaving, at_returning;
            std::size_t seam_in_first = 0, seam_in_second = 0;
            bool clear = true;
            for (std::size_t i = 0; i < n && clear; ++i) {
                const bool from = cut->beyond[i], to = cut->beyond[(i + 1) % n];
                const SideLabels& labels = part.labels[i];
                if (from == to) {
                    push(from ? halves.second : halves.first, piece.sides[i], labels, part.corner_ties[i]);
                    continue;
                }
                SideLabels before{labels.first, {}}, after;
                for (const RimTransition& t : labels.transitions) {
                    const double s = t.point[cut->upright ? 0 : 1];
                    clear = clear && std::abs(s - cut->at) > t.error;
                    ((s > cut->at) == from ? before : after).transitions.push_back(t);
                }
                after.first = before.last();
                LabelledPiece &start = from ? halves.second : halves.first,
                              &end = from ? halves.first : halves.second;
                push(start, piece.sides[i], before, part.corner_ties[i]);
                (from ? seam_in_second : seam_in_first) = start.labels.size();
                (from ? at_returning : at_leaving) = before.last();
                push(start, from ? cut->side() : cut->opposite(), {}, {});
                push(end, piece.sides[i], after, {});
            }
            if (!clear) continue;
            halves.seam = patchwork_.new_seam();
            halves.first.piece.sides[seam_in_first].id = halves.second.piece.sides[seam_in_second].id =
                halves.seam;
            halves.first.piece = make_piece(std::move(halves.first.piece.sides));
            halves.second.piece = make_piece(std::move(halves.second.piece.sides));
            const Piece& first = halves.first.piece;
            auto labels = analysis_.label_side(first.sides[seam_in_first], first.corners[seam_in_first],
                                               first.corners[(seam_in_first + 1) % first.corners.size()],
                                               at_leaving, at_returning, candidates, true);
            if (!labels) continue;
            halves.second.labels[seam_in_second] = labels->reversed();
            halves.first.labels[seam_in_first] = *std::move(labels);
            // As in split().
            if (!cut->upright) std::swap(halves.first, halves.second);
            return halves;
        }
        return std::nullopt;
    }

    Patchwork::Index conquer(const Piece& piece, std::vector<FormId>& candidates, double share) {
        const double x = 0.5 * piece.rect.x0 + 0.5 * piece.rect.x1,
                     y = 0.5 * piece.rect.y0 + 0.5 * piece.rect.y1;
        if (candidates.size() > sizes_.quartering) cull_in_quarters(piece.rect, candidates);
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
    }

    const FormFamily& family_;
    const ConvexRegion& region_;
    const EnvelopeOptions& options_;
    IdVector<FormId, Form> forms_;
    CircleKernel kernel_;
    Patchwork patchwork_;
    WorkDiagram work_;
    const Piece root_;
    MixedAnalysis analysis_;
    Sizes sizes_ = region_sizes;
    bool is_sphere_ = false, is_cylinder_ = false;
    std::size_t splits_ = 0, small_pieces_ = 0, small_pieces_in_place_ = 0;
    double done_ = 0;
    // Working space.
    std::vector<CircleKernel::Place> places_;
    std::vector<char> kept_;
    std::vector<std::pair<double, FormId>> order_;
    std::vector<FormId> lines_;
};

}  // namespace

namespace {

// How far from the middle the chart of a sphere has to reach: beyond it one form is certainly lowest. With
// (x, y) = (x', y') / (x'^2 + y'^2) every form is f / (x^2 + y^2) with its constant and quadratic terms
// exchanged, so the question is about a square |x'|, |y'| <= h; the chart reaches to 1 / h.
class ChartReach {
public:
    explicit ChartReach(const FormFamily& family) {
        for (const FormId f : family.forms.ids()) {
            const CircularForm& c = family.forms[f];
            const auto ball = [](double v) {
                return Interval::ball(v, 4 * std::numeric_limits<double>::epsilon() * std::abs(v));
            };
            const Interval w = Interval(1.0) / ball(c.w);
            circular_.push_back({Interval(c.k) * w, ball(c.a) * w, ball(c.b) * w, ball(c.e) * w});
        }
        for (const RadialForm& f : family.radial) {
            RadialForm inverted = f;  // seen from the other pole: u_z changes its sign
            inverted.b[2] = -f.b[2];
            inverted.a[2] = -f.a[2];
            radial_.emplace_back(inverted, RadialChart::Stereographic,
                                 [](const Exact& v) { return v.enclosure(); });
        }
    }

    double find() const {
        const std::size_t owner = lowest_at_pole();
        double h = 1;
        for (std::size_t i = 0; i < circular_.size() && owner < circular_.size(); ++i) {
            if (i == owner) continue;
            // v - s h - 2 e h^2 > 0: its root, and a bit less.
            const std::array<Interval, 4> d = difference(circular_[i], circular_[owner]);
            const double v = d[0].lower(), s = (d[1].magnitude() + d[2].magnitude()),
                         e = std::max(0.0, -d[3].lower());
            if (!(v > 0)) throw undecided();
            h = std::min(h, 0.999 * 2 * v / (s + std::sqrt(s * s + 8 * e * v)));
        }
        while (!is_lowest_within(owner, h)) {
            h *= 0.5;
            if (!(h > least)) throw undecided();
        }
        return 1 / h;
    }

private:
    static constexpr double least = 0x1p-40;

    static UndecidedError undecided() {
        return UndecidedError("which object is nearest around the pole of the chart");
    }

    static std::array<Interval, 4> difference(const std::array<Interval, 4>& f,
                                              const std::array<Interval, 4>& g) {
        return {f[0] - g[0], f[1] - g[1], f[2] - g[2], f[3] - g[3]};
    }

    std::size_t lowest_at_pole() const {
        std::size_t best = 0;
        double lowest = HUGE_VAL;
        const auto consider = [&](std::size_t i, double v) {
            if (v >= lowest) return;
            lowest = v;
            best = i;
        };
        for (std::size_t i = 0; i < circular_.size(); ++i) consider(i, circular_[i][0].mid());
        const RadialNormals<Interval> pole(RadialChart::Stereographic, 0.0, 0.0);
        for (std::size_t i = 0; i < radial_.size(); ++i)
            consider(circular_.size() + i, radial_[i].jet<0>(pole).v.mid());
        return best;
    }

    bool is_lowest_within(std::size_t owner, double h) const {
        const Interval x(-h, h), r2(0.0, Interval::up(2 * h * h));
        if (radial_.empty()) {
            for (std::size_t i = 0; i < circular_.size(); ++i) {
                if (i == owner) continue;
                const auto d = difference(circular_[i], circular_[owner]);
                if (!((d[0] + d[1] * x + d[2] * x + d[3] * r2).lower() > 0)) return false;
            }
            return true;
        }
        const RadialNormals<Interval> normals(RadialChart::Stereographic, x, x);
        const Interval w(1.0, Interval::up(1 + r2.upper()));
        const auto range = [&](std::size_t i) {
            if (i >= circular_.size()) return radial_[i - circular_.size()].jet<0>(normals).v;
            const auto& c = circular_[i];
            return (c[0] + c[1] * x + c[2] * x + c[3] * r2) / w;
        };
        const double top = range(owner).upper();
        for (std::size_t i = 0; i < circular_.size() + radial_.size(); ++i)
            if (i != owner && !(range(i).lower() > top)) return false;
        return true;
    }

    std::vector<std::array<Interval, 4>> circular_;  // of k, a, b, e over w
    std::vector<RadialHeight<Interval>> radial_;
};

}  // namespace

MinimizationDiagram lower_envelope(const FormFamily& family, const ConvexRegion& region,
                                   const EnvelopeOptions& options) {
    if (family.size() == 0) {
        // Any one form makes the region's face; then its label is taken away.
        FormFamily constant;
        constant.forms.push_back({});
        constant.exact = [](FormId) { return ExactForm{{}, {}, {}, {}, Exact(1.0)}; };
        MinimizationDiagram out = EnvelopeBuilder(constant, region, options).over_region();
        out.clear_labels();
        return out;
    }
    return EnvelopeBuilder(family, region, options).over_region();
}

MinimizationDiagram lower_envelope_on_sphere(const FormFamily& family, const EnvelopeOptions& options) {
    if (family.is_all_circular() && options.incremental)
        if (auto diagram = disc_diagram_on_sphere(family, options)) return *std::move(diagram);
    const double reach = ChartReach(family).find();
    return EnvelopeBuilder(family, ConvexRegion::rectangle(-reach, -reach, reach, reach), options)
        .over_sphere();
}

namespace {

// The unit of y over a cylinder. x is an angle's: pieces are square where a step of y is about as long as a
// step of x at the cell's distance from the axis. Four times that distance needs the fewest pieces on scenes
// of all kinds. A power of two, so that nothing is rounded.
double axial_unit(const FormFamily& family, double y0, double y1) {
    constexpr int along = 4, around = 4;
    const Heights heights(family);
    std::vector<double> distances;
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const double y = y0 + (y1 - y0) * (i + 0.5) / along, x = j - 0.5;
            double lowest = 0;
            for (std::uint32_t f = 0; f < family.size(); ++f)
                lowest = std::min(lowest, heights.value(FormId{f}, Interval(x), Interval(y)).mid());
            distances.push_back(-1 / lowest);
        }
    const auto median = distances.begin() + distances.size() / 2;
    std::ranges::nth_element(distances, median);
    return std::isfinite(*median) ? std::ldexp(4.0, std::ilogb(*median)) : 1;
}

// The roots next to the region of what falls to one there. Those far from it, as seen from the whole region,
// matter to no height.
AxialTips axial_tips(const std::vector<RadialForm>& forms, double y0, double y1) {
    constexpr double near = 0x1p-4;
    AxialTips tips;
    tips.reach = y1 - y0;
    for (const RadialForm& f : forms) {
        const auto end = f.falls_to();
        if (!end) continue;
        const double root = (-f.c[0].enclosure() / f.c[1].enclosure()).mid();
        std::optional<double>& tip = tips[*end];
        if (*end == AxialEnd::Low && root < y0 && y0 - root < near * (y1 - y0))
            tip = std::max(root, tip.value_or(root));
        if (*end == AxialEnd::High && root > y1 && root - y1 < near * (y1 - y0))
            tip = std::min(root, tip.value_or(root));
    }
    return tips;
}

}  // namespace

MinimizationDiagram lower_envelope_on_cylinder(const FormFamily& family, double y0, double y1,
                                               const EnvelopeOptions& options) {
    const double unit = axial_unit(family, y0, y1);
    const long exponent = std::ilogb(unit);
    FormFamily scaled = family;
    scaled.axial_unit = unit;
    for (RadialForm& f : scaled.radial) {
        f.c[1] = f.c[1].scaled(exponent);
        f.c[2] = f.c[2].scaled(2 * exponent);
        f.slope = f.slope.scaled(exponent);
    }
    scaled.tips = axial_tips(scaled.radial, y0 / unit, y1 / unit);
    const double most = std::max(1.0, unit);
    const auto to_length = [&](Assumption& a) {
        a.place.y() *= unit;
        a.width *= most;
    };
    MinimizationDiagram out = [&] {
        try {
            return EnvelopeBuilder(scaled, ConvexRegion::rectangle(-1, y0 / unit, 3, y1 / unit), options)
                .over_cylinder();
        } catch (const TieError& e) {
            Assumption tie = e.tie;
            to_length(tie);
            throw TieError(tie);
        }
    }();
    out.region = ConvexRegion::rectangle(-1, y0, 3, y1);
    out.radial = family.radial;
    for (MinimizationDiagram::Vertex& v : out.vertices) {
        v.point.y() *= unit;
        v.error *= most;
    }
    for (MinimizationDiagram::ArcPiece& p : out.pieces_) {
        p.end.y() *= unit;
        p.error *= most;
        // Where the derivative along (dx, dy) of the scaled chart is positive, so is that along (dx, unit
        // dy).
        p.direction.y() *= unit;
        p.direction.normalize();
        p.box[2] *= unit;
        p.box[3] *= unit;
    }
    for (Assumption& a : out.assumptions) to_length(a);
    return out;
}

FormId lowest_form(const FormFamily& family, double x, double y) {
    const Heights heights(family);
    Decisions decisions;
    FormId best;
    for (std::uint32_t i = 0; i < family.size(); ++i)
        if (!best.valid() || heights.compare(FormId{i}, best, x, y, decisions) == Sign::Negative)
            best = FormId{i};
    return best;
}

}  // namespace vcell
