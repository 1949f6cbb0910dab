#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "../../primitives/forms/axial_ties.hpp"
#include "../../primitives/objects/exact_space.hpp"
#include "../../primitives/objects/message.hpp"
#include "edge_errors.hpp"
#include "edge_fits.hpp"
#include "edge_lift.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"
#include "face_surfaces.hpp"
#include "radial_patch.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;

class RadialLift : public EdgeLift {
public:
    RadialLift(const RadialDiagram& of, double tolerance, unsigned threads)
        : EdgeLift(of, threads),
          loops_(of.diagram),
          patches_(of, loops_, curves_, threads),
          fits_(of, patches_, curves_, tolerance, threads),
          surfaces_(of, loops_, patches_, curves_, fits_, threads),
          errors_(of, equations_, curves_, patches_) {
        surfaces_.make();
    }

    std::string_view bisector(FormId form) const { return bisector_name(of_.problem, form); }
    void set_patches(FaceId face, std::vector<TrimmedPatch>& patches) {
        patches = std::move(surfaces_.of(face));
    }

    // The trims are compared with the space curve on patches as computed, whose control points are rounded;
    // and all of it is moved back, as for vertices.
    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) const {
        const auto [far, rounding] = set_world_curve(e, curve);
        const auto [off, trims] = errors_(e, ends, rounding);
        if (surfaces_.rounding(e) > fits_.most_error())
            throw of_.unproved(e, "rounding leaves few digits of their faces",
                               curve.points.front().head<3>());
        // Nothing of the cell is farther away than its box, which holds the base.
        const double most = 4 * far;
        return {std::min(most, off + rounding),
                std::min(most, std::max(off, trims) + surfaces_.rounding(e) + rounding)};
    }

    void finish(Cell& cell) {
        EdgeLift::finish(cell);
        if (!of_.problem.generator_ties.empty()) {
            for (const EdgeId e : of_.diagram.edges.ids())
                if (curves_.is_line(e) && !of_.diagram.edges[e].on_rim()) add_generator_ties(e, cell);
            for (const VertexId v : of_.diagram.vertices.ids()) add_generator_ties(v, cell);
        }
        if (of_.problem.common_ties.empty()) return;
        for (const EdgeId e : of_.diagram.edges.ids())
            add_common_ties(of_.diagram.label(e), cell.edges[e.value].extra_sites);
        for (const VertexId v : of_.diagram.vertices.ids())
            add_common_ties(of_.diagram.label(v), cell.vertices[v.value].sites);
    }

private:
    // Does the form tie where these do: is it in the label, or is its site among those that have been found
    // to tie? That tells nothing of one of the two walls that stand for a tube across the base's axis.
    bool ties(FormId form, std::span<const FormId> label, const auto& sites) const {
        if (std::ranges::find(label, form) != label.end()) return true;
        const bool is_one_of_two = of_.problem.given[form].index() != of_.problem.objects[form].index();
        return !is_one_of_two && std::ranges::find(sites, of_.problem.sites[form].front()) != sites.end();
    }

    // What ties may stand for another form in the next tie.
    void add_common_ties(std::span<const FormId> label, auto& sites) const {
        for (std::size_t known = sites.size() + 1; known != sites.size();) {
            known = sites.size();
            for (const RadialBaseProblem::CommonTie& tie : of_.problem.common_ties)
                if (ties(tie.first, label, sites) && ties(tie.second, label, sites))
                    sites.push_back(tie.site);
            sort_unique(sites);
        }
    }

    // Two forms change places over one generator as the angle grows, and back over the other they have in
    // common.
    void add_generator_ties(EdgeId e, Cell& cell) {
        CellEdge& edge = cell.edges[e.value];
        const Vector4d &from = curves_.from(e), &to = curves_.to(e);
        const bool is_upward = from.y() < to.y();
        const FormId left = of_.diagram.edges[e].left, right = of_.diagram.edges[e].right;
        bool is_decided = true;
        for (const RadialBaseProblem::GeneratorTie& tie : of_.problem.generator_ties) {
            if (tie.before != (is_upward ? left : right) || tie.after != (is_upward ? right : left)) continue;
            is_decided = is_decided && tie.is_decided;
            edge.extra_sites.push_back(tie.site);
            for (const VertexId v : {of_.diagram.start(e), of_.diagram.end(e)}) {
                auto& sites = cell.vertices[v.value].sites;
                sites.push_back(tie.site);
                sort_unique(sites);
            }
        }
        sort_unique(edge.extra_sites);
        if (is_decided) return;
        ++decisions_.assumed;
        const double off = of_.problem.unit * off_assumed_tie(left, right, from);
        for (const VertexId v : {of_.diagram.start(e), of_.diagram.end(e)})
            cell.vertices[v.value].error += off;
        std::string sites = to_string(edge.sites[0]) + ", " + to_string(edge.sites[1]);
        for (const Site site : edge.extra_sites) sites += ", " + to_string(site);
        const Vector4d middle = 0.5 * (from + to);
        cell.report.warnings.push_back(
            "objects " + sites + ": taken to meet in one line through " +
            to_text(of_.problem.unit * of_.problem.frame.to_world(middle.head<3>())) +
            ", not told apart within " + to_text(of_.problem.unit * narrow_tie * middle.w()));
    }

    // Where another form is nearer over all of the generator but a point, the tie has no edge, and a vertex.
    void add_generator_ties(VertexId v, Cell& cell) {
        auto& sites = cell.vertices[v.value].sites;
        const auto known = sites;
        const auto has = [&](FormId f) { return ties(f, of_.diagram.label(v), known); };
        for (const RadialBaseProblem::GeneratorTie& tie : of_.problem.generator_ties)
            if (tie.is_decided && has(tie.before) && has(tie.after) &&
                give_way(tie.before, tie.after, of_.diagram.vertices[v]))
                sites.push_back(tie.site);
        sort_unique(sites);
    }
    // Two forms without roots are equally near in a vertex. Does the first give way to the second there as
    // the angle grows? Nearness F (axial_ties.hpp) changes with it by 2 (b.w') / c0, w' being (1 - x^2, 0, -2
    // x) / (1 + x^2) at the half angle's tangent x.
    bool give_way(FormId first, FormId second, const MinimizationDiagram::Vertex& vertex) const {
        const bool is_back = of_.problem.chart.is_back(vertex.point.x());
        const Interval x = Interval::ball(vertex.point.x(), vertex.error) - Interval(is_back ? 2.0 : 0.0);
        const auto slope = [&](FormId form) {
            const RadialForm& f = of_.problem.family.radial_form(form);
            const Interval on_front =
                (f.b[0].enclosure() * (Interval(1.0) - square(x)) - f.b[2].enclosure() * Interval(2.0) * x) /
                f.c[0].enclosure();
            return is_back ? -on_front : on_front;
        };
        return (slope(second) - slope(first)).sign() == Sign::Positive;
    }

    // The site's nearness q is a mean of both forms' up to narrow_tie, so that its slope in the angle differs
    // from that of one of them by half of theirs at least: the two tie beside the point, along their
    // bisector, a part of 2 narrow_tie q / |q1' - q2'| of a turn away. Without roots q'/q is b.w' / (b0 +
    // b.w).
    double off_assumed_tie(FormId first, FormId second, const Vector4d& point) const {
        const double away = std::hypot(point.x(), point.z()), sine = point.x() / away,
                     cosine = point.z() / away;
        const auto slope = [&](FormId form) {
            const RadialForm& f = of_.problem.family.radial_form(form);
            const double b0 = nearest(f.b0), x = nearest(f.b[0]), z = nearest(f.b[2]);
            return (x * cosine - z * sine) / (b0 + x * sine + z * cosine);
        };
        const double one = slope(first), other = slope(second);
        const double apart = std::abs(one - other), steepest = std::max(std::abs(one), std::abs(other));
        return 2 * narrow_tie * away * std::hypot(1, steepest) / apart;
    }

    FaceLoops loops_;
    radial::FacePatches patches_;
    radial::EdgeFits fits_;
    radial::FaceSurfaces surfaces_;
    radial::EdgeErrors errors_;
};

}  // namespace

LiftedCell lift_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                           double tolerance, bool with_measures, unsigned threads) {
    if (problem.floor.empty()) {
        RadialLift lift({problem, diagram}, tolerance, threads);
        return CellAssembly(lift, threads)(with_measures);
    }
    // Where the cell has no faces the diagram has no forms.
    MinimizationDiagram shown = diagram;
    for (FormId& form : shown.face_forms)
        if (form.valid() && !problem.shows(form, diagram.is_below_floor)) form = {};
    RadialLift lift({problem, shown}, tolerance, threads);
    return CellAssembly(lift, threads)(with_measures);
}

}  // namespace vcell
