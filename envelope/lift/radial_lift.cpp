#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "../../primitives/forms/axial_ties.hpp"
#include "../../primitives/objects/message.hpp"
#include "../measures/measures.hpp"
#include "based_diagram.hpp"
#include "cell_assembly.hpp"
#include "edge_equations.hpp"
#include "edge_errors.hpp"
#include "edge_fits.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"
#include "face_surfaces.hpp"
#include "radial_curves.hpp"
#include "radial_patch.hpp"
#include "radial_vertices.hpp"
#include "sphere_arcs.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;

using roundoff::u;

class RadialLift {
public:
    RadialLift(const RadialDiagram& of, double tolerance)
        : of_(of),
          problem_(of.problem),
          diagram_(of.diagram),
          origin_(of.problem.frame.origin.norm()),
          equations_(of),
          vertices_(of, equations_),
          curves_(with_sphere_arcs(radial::RadialCurves(of, vertices_, equations_))),
          loops_(of.diagram),
          patches_(of, loops_, curves_),
          fits_(of, patches_, curves_, tolerance),
          surfaces_(of, loops_, patches_, curves_, fits_),
          errors_(of, equations_, curves_, patches_) {
        surfaces_.make();
    }

    const RadialDiagram& of() const { return of_; }
    Decisions decisions() const {
        Decisions sum = equations_.decisions();
        return sum += decisions_;
    }

    LiftedVertex vertex(VertexId v) const {
        return {vertices_.point(v), vertices_[v].w() - problem_.chart.radius, vertices_.error(v)};
    }
    void add_rim_sites(VertexId v, SmallVector<Site, 4>& sites) const { of_.add_rim_sites(v, sites); }
    std::string_view bisector(FormId form) const { return bisector_name(problem_, form); }
    void set_patches(FaceId face, std::vector<TrimmedPatch>& patches) {
        patches = std::move(surfaces_.of(face));
    }
    CurveKind kind(EdgeId e) const { return equations_.kind(e); }

    // The trims are compared with the space curve on patches as computed, whose control points are rounded;
    // and all of it is moved back, as for vertices.
    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) {
        curves_.to_world(e, problem_.frame, curve);
        double square = origin_ * origin_;
        for (const Vector4d& p : curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double far = std::sqrt(square), rounding = 16 * u * (far + origin_);
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
        if (problem_.generator_ties.empty()) return;
        for (const EdgeId e : diagram_.edges.ids())
            if (curves_.is_line(e) && !diagram_.edges[e].on_rim()) add_generator_ties(e, cell);
    }

    void measure(const IdVector<EdgeId, double>& positions, Cell& cell) const {
        measure_all_around(problem_, diagram_, positions, cell);
    }

private:
    radial::RadialCurves with_sphere_arcs(radial::RadialCurves curves) {
        add_sphere_arcs(of_, equations_, curves, decisions_);
        return curves;
    }

    // Two forms change places over one generator as the angle grows, and back over the other they have in
    // common.
    void add_generator_ties(EdgeId e, Cell& cell) {
        CellEdge& edge = cell.edges[e.value];
        const Vector4d &from = curves_.from(e), &to = curves_.to(e);
        const bool is_upward = from.y() < to.y();
        const FormId left = diagram_.edges[e].left, right = diagram_.edges[e].right;
        bool is_decided = true;
        for (const RadialBaseProblem::GeneratorTie& tie : problem_.generator_ties) {
            if (tie.before != (is_upward ? left : right) || tie.after != (is_upward ? right : left)) continue;
            is_decided = is_decided && tie.is_decided;
            edge.extra_sites.push_back(tie.site);
            for (const VertexId v : {diagram_.start(e), diagram_.end(e)}) {
                auto& sites = cell.vertices[v.value].sites;
                sites.push_back(tie.site);
                sort_unique(sites);
            }
        }
        sort_unique(edge.extra_sites);
        if (is_decided) return;
        ++decisions_.assumed;
        std::string sites = to_string(edge.sites[0]) + ", " + to_string(edge.sites[1]);
        for (const Site site : edge.extra_sites) sites += ", " + to_string(site);
        const Vector4d middle = 0.5 * (from + to);
        cell.report.warnings.push_back("objects " + sites + ": taken to meet in one line through " +
                                       to_text(problem_.unit * problem_.frame.to_world(middle.head<3>())) +
                                       ", not told apart within " +
                                       to_text(problem_.unit * narrow_tie * middle.w()));
    }

    const RadialDiagram of_;
    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const double origin_;  // how far the frame's is from the world's
    Decisions decisions_;
    radial::EdgeEquations equations_;
    const radial::RadialVertices vertices_;
    radial::RadialCurves curves_;
    FaceLoops loops_;
    radial::FacePatches patches_;
    radial::EdgeFits fits_;
    radial::FaceSurfaces surfaces_;
    radial::EdgeErrors errors_;
};

}  // namespace

LiftedCell lift_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                           double tolerance, bool with_measures) {
    if (problem.floor.empty()) {
        RadialLift lift({problem, diagram}, tolerance);
        return CellAssembly(lift)(with_measures);
    }
    // Where the cell has no faces the diagram has no forms.
    MinimizationDiagram shown = diagram;
    for (FormId& form : shown.face_forms)
        if (form.valid() && !problem.shows(form, diagram.is_below_floor)) form = {};
    RadialLift lift({problem, shown}, tolerance);
    return CellAssembly(lift)(with_measures);
}

}  // namespace vcell
