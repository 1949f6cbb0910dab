// The recursion of [HE, section 2.1] with the region split before the forms are: over a small piece of the
// region only the forms that are lowest somewhere in it matter, whatever their total number, and there the
// diagrams are merged. The pieces' diagrams are glued along the seams (patchwork.hpp).
//
// Within a piece the recursion splits off one form at a time: the diagram of one form is a single face, so
// its overlay with the rest is the rest itself, and no crossing of unrelated trisectors is ever computed. Of
// many forms each is sought by walking (work_walk.cpp); of few it is compared with all faces. A piece in
// which many meet in one vertex, so that they cannot be culled, is halved and merged by overlay, which keeps
// the worst case at O(n log n) overlays of what is there.
//
// Where a cylinder competes the pieces are split until they are plain (mixed_piece.hpp); the labels along
// their sides are found once, when the side is made, so that the pieces beside a seam cannot disagree. Pieces
// without a competing cylinder are left to exact merging.
//
// Circular forms over a plane are linear on the sphere, too (../sphere); but there faces have to be discs and
// each form's only one, and over a plane some forms have two faces, or are islands in those of others.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "../../core/errors.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../diagram/patchwork.hpp"
#include "../proofs/mixed_analysis.hpp"
#include "../sphere/sphere_diagram.hpp"
#include "chart_reach.hpp"
#include "circular_recursion.hpp"
#include "pieces.hpp"

namespace vcell {

namespace {

constexpr PieceSizes region_sizes{64, 16}, sphere_sizes{32, 4};
// Pieces with more competitors than this are not plain: looking closer is a waste.
constexpr std::size_t most_competitors = 6, most_around_cylinder = 4;
// More that tie in a point are seen to where pieces are so small that nothing else is left in them.
constexpr std::size_t most_tied = 8;
// A tube's circumference is cut into such parts of it as long as there are more competitors than this.
constexpr std::size_t most_around = 32;
constexpr double part_around = 0.075;
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
class EnvelopeBuilder {
public:
    EnvelopeBuilder(const FormFamily& family, const ConvexRegion& region, const EnvelopeOptions& options,
                    PieceSizes sizes = region_sizes)
        : family_(family),
          region_(region),
          options_(options),
          progress_(options.progress),
          patchwork_(family, family.forms.size()),
          circular_(family, options, sizes, progress_, patchwork_),
          root_(make_piece(sides_of(region))),
          analysis_(family, extent(root_.rect), options),
          cutter_(family) {}

    MinimizationDiagram over_region() {
        solve_all(root_, 1.0);
        return finish();
    }

    // Pre: the region's rim, and all beyond it, belongs to one form.
    MinimizationDiagram without_rim() {
        patchwork_.drop_rim(solve_all(root_, 1.0));
        MinimizationDiagram result = finish();
        result.region = {};
        return result;
    }

    // The region is [-1, 3] x [y0, y1] of half-angle coordinates; both halves are smooth pieces, and together
    // they close. The seams are labelled once.
    MinimizationDiagram once_around() {
        most_competitors_ = most_around_cylinder;
        const double circumference = family_.chart.circumference();
        const double y0 = root_.rect.y0, y1 = root_.rect.y1;
        const std::uint32_t middle = patchwork_.new_seam(), left = patchwork_.new_seam(),
                            right = patchwork_.new_seam();
        const PieceSide bottom{0, 1, -y0, 0}, top{0, -1, y1, 2};
        LabelledPiece front = label(make_piece({bottom, {-1, 0, 1, middle}, top, {1, 0, 1, left}})),
                      back = label(make_piece({bottom, {-1, 0, 3, right}, top, {1, 0, -1, middle}}));
        back.labels[3] = front.labels[1].reversed();
        back.labels[1] = front.labels[3].reversed();
        for (RimTransition& t : back.labels[1].transitions) t.point.x() += circumference;
        const Patchwork::Index all = patchwork_.glue(solve_labelled(front, with_floor(), 0.5),
                                                     solve_labelled(back, with_floor(), 0.5), middle);
        patchwork_.close(all, right, left, circumference, top.id);
        return finish();
    }

private:
    std::vector<FormId> with_floor() const {
        std::vector<FormId> all(family_.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = FormId{i};
        return all;
    }
    std::vector<FormId> without_floor(std::vector<FormId> forms) const {
        std::erase_if(forms,
                      [&](FormId f) { return std::ranges::find(options_.floor, f) != options_.floor.end(); });
        return forms;
    }

    Patchwork::Index solve_all(const RegionPiece& piece, double share) {
        if (family_.is_all_circular()) return circular_.solve(piece, without_floor(with_floor()), share);
        return solve_labelled(label(piece), with_floor(), share);
    }

    MinimizationDiagram finish() {
        MinimizationDiagram result = patchwork_.finish(analysis_.competition().heights());
        result.region = region_;
        result.floor = options_.floor;
        result.is_below_floor = options_.is_below_floor;
        for (MinimizationDiagram::Edge& edge : result.edges)
            if (!edge.on_rim() && result.has_lower_across(edge.left, edge.right))
                std::swap(edge.left, edge.right);
        result.decisions = circular_.decisions();
        result.decisions += analysis_.competition().decisions();
        result.work = circular_.effort();
        result.work.pieces = resolved_;
        result.assumptions = std::move(analysis_.competition().assumptions());
        return result;
    }

    static Sides sides_of(const ConvexRegion& region) {
        Sides sides;
        for (std::uint32_t i = 0; i < region.sides.size(); ++i)
            sides.push_back({region.sides[i].a, region.sides[i].b, region.sides[i].c, i});
        return sides;
    }

    // --- Pieces in which cylinders compete. ---------------------------------------------------------------

    LabelledPiece label(const RegionPiece& piece) {
        const Rectangle& r = piece.rect;
        const std::vector<FormId> candidates =
            analysis_.rivals().cull({r.x0, r.x1, r.y0, r.y1}, with_floor());
        const std::size_t n = piece.sides.size();
        LabelledPiece out{piece, {}, {}};
        std::vector<FormId> first(n), last(n);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t before = (i + n - 1) % n;
            std::vector<FormId> ties =
                analysis_.sides().lowest_at(piece.sides[before], piece.sides[i], candidates);
            first[i] = last[before] = ties.front();
            if (ties.size() == 1) {
                ties.clear();
            } else {
                first[i] = analysis_.sides().label_beside(piece.sides[i], piece.corners[i],
                                                          piece.corners[(i + 1) % n], ties);
                last[before] = analysis_.sides().label_beside(piece.sides[before], piece.corners[i],
                                                              piece.corners[before], ties);
            }
            out.corner_ties.push_back(std::move(ties));
        }
        for (std::size_t i = 0; i < n; ++i) {
            auto labels = analysis_.sides().label_side(piece.sides[i], piece.corners[i],
                                                       piece.corners[(i + 1) % n], first[i], last[i],
                                                       candidates, Patchwork::is_seam(piece.sides[i].id));
            if (!labels) throw TieError(analysis_.sides().obstacle().value_or(all_of(r, candidates)));
            out.labels.push_back(*std::move(labels));
        }
        return out;
    }

    Patchwork::Index solve_labelled(const LabelledPiece& part, std::span<const FormId> inherited,
                                    double share) {
        const Rectangle& r = part.piece.rect;
        std::vector<FormId> candidates = analysis_.rivals().cull({r.x0, r.x1, r.y0, r.y1}, inherited);
        if (std::ranges::all_of(candidates, [&](FormId f) { return family_.is_circular(f); }))
            // Of the floor alone there is nothing to merge: it stays one of the pieces that follow.
            if (const std::vector<FormId> others = without_floor(candidates); !others.empty())
                return circular_.solve(part.piece, others, share);
        const double size = extent(r) / analysis_.competition().extent_at({r.x0, r.x1}, {r.y0, r.y1});
        const bool at_floor = size <= floor_width,
                   is_small = extent(r) <=
                              tie_width * analysis_.competition().tie_extent_at({r.x0, r.x1}, {r.y0, r.y1});
        if (candidates.size() <= most_competitors_ || (is_small && candidates.size() <= most_tied) ||
            size <= node_width) {
            if (const auto resolved = analysis_.resolve(
                    {part.piece.sides, part.piece.corners, part.labels, part.corner_ties})) {
                progress_.add(share);
                ++resolved_;
                return patchwork_.add(*resolved);
            }
            candidates = analysis_.remaining();
        }
        if (size >= small_part) {
            small_pieces_in_place_ = 0;  // those of the places before are done
        } else {
            ++small_pieces_;
            ++small_pieces_in_place_;
        }
        splits_ += analysis_.competition().heights().cost();
        if (at_floor || splits_ > most_splits + splits_of_form * family_.size() ||
            analysis_.sides().is_spent() || small_pieces_ > small_pieces_of_form * family_.size() ||
            small_pieces_in_place_ > most_small_pieces_in_place)
            throw TieError(all_of(r, candidates));
        const auto halves = split_labelled(part, candidates);
        if (!halves) throw TieError(analysis_.sides().obstacle().value_or(all_of(r, candidates)));
        const Patchwork::Index a = solve_labelled(halves->first, candidates, 0.5 * share);
        const Patchwork::Index b = solve_labelled(halves->second, candidates, 0.5 * share);
        return patchwork_.glue(a, b, halves->seam);
    }

    static Assumption all_of(const Rectangle& r, std::vector<FormId> forms) {
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
    std::optional<bool> cut_upright(const Rectangle& r, std::size_t candidates) const {
        if (candidates > most_around && r.x1 - r.x0 > part_around * family_.chart.circumference())
            return true;
        // No one metric suits tubes that are all but parallel to the base.
        constexpr double strip_part = 0x1p-4;
        if (family_.chart.is_cylinder() && extent(r) < strip_part * extent(root_.rect))
            if (const auto upright = analysis_.rivals().asks_for_strips({r.x0, r.x1, r.y0, r.y1}))
                return upright;
        const auto steepness = analysis_.rivals().steepness_across(r.x1 - r.x0, r.y1 - r.y0);
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
        const auto upright = cut_upright(part.piece.rect, candidates.size());
        for (const double shift : {0.0, 0.03, -0.03, 0.07, -0.07, 0.11, -0.11, 0.17, -0.17}) {
            const auto cut = cutter_.cut_at(part.piece, shift, upright);
            if (!cut) continue;
            auto halves = PieceCutter::labelled_halves(part, *cut);
            if (!halves) continue;
            auto& [first, second, in_first, in_second, at_leaving, at_returning] = *halves;
            const std::uint32_t seam = patchwork_.new_seam();
            first.piece.sides[in_first].id = second.piece.sides[in_second].id = seam;
            auto labels =
                analysis_.sides().label_side(first.piece.sides[in_first], first.piece.corners[in_first],
                                             first.piece.corners[(in_first + 1) % first.piece.corners.size()],
                                             at_leaving, at_returning, candidates, true);
            if (!labels) continue;
            second.labels[in_second] = labels->reversed();
            first.labels[in_first] = *std::move(labels);
            // The first piece is to lie left of the upright seam; a level one is turned by a right angle.
            if (!cut->upright) std::swap(first, second);
            return LabelledHalves{std::move(first), std::move(second), seam};
        }
        return std::nullopt;
    }

    const FormFamily& family_;
    const ConvexRegion& region_;
    const EnvelopeOptions& options_;
    SharedProgress progress_;
    Patchwork patchwork_;
    CircularRecursion circular_;
    const RegionPiece root_;
    MixedAnalysis analysis_;
    PieceCutter cutter_;
    std::size_t most_competitors_ = most_competitors;
    std::size_t resolved_ = 0, splits_ = 0, small_pieces_ = 0, small_pieces_in_place_ = 0;
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
    const double reach = chart_reach(family);
    return EnvelopeBuilder(family, ConvexRegion::rectangle(-reach, -reach, reach, reach), options,
                           sphere_sizes)
        .without_rim();
}

namespace {

// The unit of y over a cylinder. x is an angle's: pieces are square where a step of y is about as long as a
// step of x at the cell's distance from the axis. Four times that distance needs the fewest pieces on scenes
// of all kinds. A power of two, so that nothing is rounded.
double axial_unit(const FormFamily& family, double y0, double y1, std::span<const FormId> box_sides) {
    constexpr int along = 4, around = 4;
    // Where the axis all but lies on a side of the box that is next to nothing in the directions towards it,
    // and tells nothing of the others.
    constexpr double least_part = 0x1p-16;
    const Heights heights(family);
    std::vector<double> distances;
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const double y = y0 + (y1 - y0) * (i + 0.5) / along, x = j - 0.5;
            double lowest = 0;
            FormId form;
            for (std::uint32_t f = 0; f < family.size(); ++f)
                if (const double v = heights.value(FormId{f}, Interval(x), Interval(y)).mid(); v < lowest) {
                    lowest = v;
                    form = FormId{f};
                }
            const bool is_beside =
                -1 / lowest < least_part * (y1 - y0) && std::ranges::find(box_sides, form) != box_sides.end();
            if (!is_beside) distances.push_back(-1 / lowest);
        }
    if (distances.empty()) return 1;
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
    const double unit = axial_unit(family, y0, y1, options.box_sides);
    const long exponent = std::ilogb(unit);
    FormFamily scaled = family;
    scaled.axial_unit = unit;
    for (RadialForm& f : scaled.radial) {
        f.c[1] = f.c[1].scaled(exponent);
        f.c[2] = f.c[2].scaled(2 * exponent);
        f.slope = f.slope.scaled(exponent);
    }
    scaled.tips = axial_tips(scaled.radial, y0 / unit, y1 / unit);
    // What is nowhere lowest may show beside a floor.
    std::vector<RingTie> ties;
    if (options.floor.empty()) ties = find_ring_ties(scaled.radial, y0 / unit, y1 / unit);
    for (const RingTie& tie : ties) scaled.hidden.push_back({FormId{tie.form}, tie.from, tie.to});
    const double most = std::max(1.0, unit);
    const auto to_length = [&](Assumption& a) {
        a.place.y() *= unit;
        a.width *= most;
    };
    MinimizationDiagram out = [&] {
        try {
            return EnvelopeBuilder(scaled, ConvexRegion::rectangle(-1, y0 / unit, 3, y1 / unit), options)
                .once_around();
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
    for (RingTie& tie : ties) {
        tie.y = unit * tie.y;
        if (tie.elsewhere) tie.elsewhere = unit * *tie.elsewhere;
        tie.from *= unit;
        tie.to *= unit;
    }
    out.ring_ties = std::move(ties);
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
