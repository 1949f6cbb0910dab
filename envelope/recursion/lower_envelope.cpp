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
// Where a cylinder competes pieces are split until enclosures decide them (mixed_recursion.hpp).
//
// Circular forms over a plane are linear on the sphere, too (../sphere); but there faces have to be discs and
// each form's only one, and over a plane some forms have two faces, or are islands in those of others.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "../../core/errors.hpp"
#include "../../primitives/forms/pencil_ties.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../diagram/patchwork.hpp"
#include "../proofs/side_labelling.hpp"
#include "../sphere/sphere_diagram.hpp"
#include "chart_reach.hpp"
#include "circular_recursion.hpp"
#include "mixed_recursion.hpp"
#include "pieces.hpp"

namespace vcell {

namespace {

constexpr PieceSizes region_sizes{64, 16}, sphere_sizes{32, 4};
constexpr std::size_t most_in_region = 6, most_around_cylinder = 4;

class EnvelopeBuilder {
public:
    EnvelopeBuilder(const FormFamily& family, const ConvexRegion& region, const EnvelopeOptions& options,
                    PieceSizes sizes = region_sizes, std::size_t most_competitors = most_in_region)
        : family_(family),
          region_(region),
          options_(options),
          progress_(options.progress),
          patchwork_(family, family.forms.size()),
          circular_(family, options, sizes, progress_, patchwork_),
          root_(make_piece(sides_of(region))),
          mixed_(family, options, root_.rect, most_competitors, progress_, circular_, patchwork_) {}

    MinimizationDiagram over_region() {
        solve_all(root_, 1.0);
        return finish();
    }

    // Pre: the region's rim, and all beyond it, belongs to one form. `hidden`: what ties of forms that are
    // hidden everywhere.
    MinimizationDiagram without_rim(std::span<const FormMesh::HiddenTie> hidden) {
        patchwork_.drop_rim(solve_all(root_, 1.0));
        are_ties_told_ = patchwork_.tie_hidden(hidden);
        MinimizationDiagram result = finish();
        result.region = {};
        return result;
    }

    // The region is [-1, 3] x [y0, y1] of half-angle coordinates; both halves are smooth pieces, and together
    // they close. The seams are labelled once.
    MinimizationDiagram once_around() {
        const double circumference = family_.chart.circumference();
        const double y0 = root_.rect.y0, y1 = root_.rect.y1;
        const std::uint32_t middle = patchwork_.new_seam(), left = patchwork_.new_seam(),
                            right = patchwork_.new_seam();
        const PieceSide bottom{0, 1, -y0, 0}, top{0, -1, y1, 2};
        LabelledPiece front = mixed_.label(make_piece({bottom, {-1, 0, 1, middle}, top, {1, 0, 1, left}})),
                      back = mixed_.label(make_piece({bottom, {-1, 0, 3, right}, top, {1, 0, -1, middle}}));
        back.labels[3] = front.labels[1].reversed();
        back.labels[1] = front.labels[3].reversed();
        for (RimTransition& t : back.labels[1].transitions) t.point.x() += circumference;
        const Patchwork::Index second = mixed_.solve(std::move(back), 0.5),
                               first = mixed_.solve(std::move(front), 0.5),
                               all = patchwork_.glue(first, second, middle);
        patchwork_.close(all, right, left, circumference, top.id);
        return finish();
    }

    // Is it known of all that is hidden where it ties?
    bool are_ties_told() const { return are_ties_told_; }

private:
    std::vector<FormId> without_floor() const {
        std::vector<FormId> forms;
        for (std::uint32_t i = 0; i < family_.size(); ++i)
            if (std::ranges::find(options_.floor, FormId{i}) == options_.floor.end())
                forms.push_back(FormId{i});
        return forms;
    }

    Patchwork::Index solve_all(const RegionPiece& piece, double share) {
        if (family_.is_all_circular()) return circular_.solve(piece, without_floor(), share);
        return mixed_.solve(mixed_.label(piece), share);
    }

    MinimizationDiagram finish() {
        Decisions along_rim;
        if (!family_.is_all_circular() && family_.are_quadratic() && options_.floor.empty())
            patchwork_.tie_along_rim([&](std::uint32_t side, const Eigen::Vector2d& from,
                                         const Eigen::Vector2d& to, FormId f, FormId g) {
                return are_one_along(family_, root_.sides[side], from, to, f, g, along_rim);
            });
        tie_along_common_curves();
        MinimizationDiagram result = patchwork_.finish(mixed_.heights());
        result.region = region_;
        result.floor = options_.floor;
        result.is_below_floor = options_.is_below_floor;
        for (MinimizationDiagram::Edge& edge : result.edges)
            if (!edge.on_rim() && result.has_lower_across(edge.left, edge.right))
                std::swap(edge.left, edge.right);
        result.decisions = circular_.decisions();
        result.decisions += mixed_.decisions();
        result.decisions += along_rim;
        result.work = circular_.effort();
        result.work.pieces = mixed_.pieces();
        result.assumptions = std::move(mixed_.assumptions());
        return result;
    }

    // Names what ties along edges in which the bisectors with three objects meet.
    void tie_along_common_curves() {
        const std::vector<CommonCurves::Triple> triples = mixed_.common_curves();
        if (triples.empty()) return;
        const Heights& heights = mixed_.heights();
        const FloorRule rule(family_, options_);
        CommonCurves curves(heights, rule);
        const double room = 0x1p-36 * extent(root_.rect);  // to look at what is around a point
        std::vector<FormMesh::HiddenTie> ties;
        for (const CommonCurves::Triple& three : triples)
            for (std::size_t i = 0; i < three.size(); ++i) {
                const FormId form = three[i], other = three[(i + 1) % 3];
                const auto is_tie = [&, three, form,
                                     other](const FormMesh::ChartBox& box) -> std::optional<bool> {
                    const Interval about(-room, room);
                    if (curves.is_common(three, box.x + about, box.y + about)) return true;
                    const auto sign = heights.value_difference(form, other, box.x, box.y).sign();
                    if (!sign || *sign == Sign::Zero) return std::nullopt;
                    return false;
                };
                ties.push_back({form, {other, three[(i + 2) % 3]}, is_tie});
            }
        patchwork_.tie_hidden(ties);
    }

    static Sides sides_of(const ConvexRegion& region) {
        Sides sides;
        for (std::uint32_t i = 0; i < region.sides.size(); ++i)
            sides.push_back({region.sides[i].a, region.sides[i].b, region.sides[i].c, i});
        return sides;
    }

    const FormFamily& family_;
    const ConvexRegion& region_;
    const EnvelopeOptions& options_;
    SharedProgress progress_;
    Patchwork patchwork_;
    CircularRecursion circular_;
    const RegionPiece root_;
    MixedRecursion mixed_;
    bool are_ties_told_ = true;
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

namespace {

// None if it is not told where the hidden ones tie.
std::optional<MinimizationDiagram> by_pieces_on_sphere(const FormFamily& family,
                                                       const EnvelopeOptions& options,
                                                       std::span<const FormMesh::HiddenTie> hidden = {}) {
    const double reach = chart_reach(family);
    const ConvexRegion all = ConvexRegion::rectangle(-reach, -reach, reach, reach);
    EnvelopeBuilder builder(family, all, options, sphere_sizes);
    MinimizationDiagram diagram = builder.without_rim(hidden);
    if (!builder.are_ties_told()) return std::nullopt;
    return diagram;
}

// Is the linear form less than zero in the box? None if its sign is not the same in all of it.
std::optional<bool> is_negative(const ExactForm& form, const FormMesh::ChartBox& box) {
    const auto sign = (form.K.enclosure() * (square(box.x) + square(box.y)) + form.A.enclosure() * box.x +
                       form.B.enclosure() * box.y + form.C.enclosure())
                          .sign();
    if (!sign || *sign == Sign::Zero) return std::nullopt;
    return *sign == Sign::Negative;
}

// A factor keeps its sign all along an edge, as heights come to zero nowhere.
std::vector<FormMesh::HiddenTie> hidden_ties(const FormFamily& family, std::span<const PencilTie> ties) {
    std::vector<FormMesh::HiddenTie> hidden;
    for (const PencilTie& tie : ties) {
        hidden.push_back({tie.form, tie.between, {}});
        if (tie.is_factor)
            hidden.back().is_tie = [form = family.exact(tie.form)](const FormMesh::ChartBox& box) {
                return is_negative(form, box);
            };
    }
    return hidden;
}

}  // namespace

MinimizationDiagram lower_envelope_on_sphere(const FormFamily& family, const EnvelopeOptions& options) {
    if (family.is_all_circular()) {
        if (options.incremental)
            if (auto diagram = disc_diagram_on_sphere(family, options)) return *std::move(diagram);
        return *by_pieces_on_sphere(family, options);
    }
    std::vector<PencilTie> ties = find_pencil_ties(family);
    while (!ties.empty()) {
        FormFamily others = family;
        for (const PencilTie& tie : ties)
            if (std::ranges::none_of(others.hidden, [&](const auto& h) { return h.form == tie.form; }))
                others.hide(tie.form);
        if (auto diagram = by_pieces_on_sphere(others, options, hidden_ties(family, ties)))
            return *std::move(diagram);
        std::erase_if(ties, &PencilTie::is_factor);
    }
    return *by_pieces_on_sphere(family, options);
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
    // Beside a floor, whose forms come last, what is nowhere the least of the others does not show, either.
    std::vector<RingTie> ties = find_ring_ties(
        std::span(scaled.radial).first(scaled.radial.size() - options.floor.size()), y0 / unit, y1 / unit);
    for (const RingTie& tie : ties)
        scaled.hidden.push_back({FormId{tie.form}, {-infinity, infinity}, {tie.from, tie.to}});
    const double most = std::max(1.0, unit);
    const auto to_length = [&](Assumption& a) {
        a.place.y() *= unit;
        a.width *= most;
    };
    MinimizationDiagram out = [&] {
        try {
            return EnvelopeBuilder(scaled, ConvexRegion::rectangle(-1, y0 / unit, 3, y1 / unit), options,
                                   region_sizes, most_around_cylinder)
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
