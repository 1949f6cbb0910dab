#include "radial_lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "../../primitives/forms/axial_ties.hpp"
#include "../../primitives/objects/message.hpp"
#include "../measures/measures.hpp"
#include "../measures/radial_measures.hpp"
#include "based_diagram.hpp"
#include "edge_equations.hpp"
#include "edge_errors.hpp"
#include "edge_fits.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"
#include "face_surfaces.hpp"
#include "joined_spans.hpp"
#include "radial_curves.hpp"
#include "radial_patch.hpp"
#include "radial_vertices.hpp"
#include "sphere_arcs.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

class RadialLifter {
public:
    RadialLifter(const RadialDiagram& of, double tolerance)
        : of_(of),
          problem_(of.problem),
          diagram_(of.diagram),
          equations_(of),
          vertices_(of, equations_),
          curves_(with_sphere_arcs(radial::RadialCurves(of, vertices_, equations_))),
          loops_(of.diagram),
          patches_(of, loops_, curves_),
          fits_(of, patches_, curves_, tolerance),
          surfaces_(of, loops_, patches_, curves_, fits_),
          errors_(of, equations_, curves_, patches_) {}

    LiftedCell lift(bool with_measures) {
        surfaces_.make();
        add_vertices();
        add_faces();
        add_edges();
        if (with_measures)
            measure(problem_, diagram_, positions_, cell_);
        else
            rank_neighbors(cell_);
        cell_.report.decisions = diagram_.decisions;
        cell_.report.decisions += equations_.decisions();
        cell_.report.decisions += decisions_;
        return {std::move(cell_), std::move(positions_)};
    }

private:
    radial::RadialCurves with_sphere_arcs(radial::RadialCurves curves) {
        if (problem_.is_sphere) add_sphere_arcs(of_, equations_, curves, decisions_);
        return curves;
    }

    void add_vertices() {
        cell_.vertices.reserve(diagram_.vertices.size());
        for (const VertexId v : diagram_.vertices.ids()) {
            CellVertex& vertex = append_new(cell_.vertices);
            vertex.point = problem_.frame.to_world(vertices_.point(v));
            vertex.radius = vertices_[v].w() - problem_.radius;
            vertex.error = vertices_.error(v);
            for (const FormId f : diagram_.label(v))
                for (const Site site : problem_.sites[f]) vertex.sites.push_back(site);
            for (const std::uint32_t side : diagram_.sides(v))
                vertex.sites.push_back(rim_site(problem_, side));
            sort_unique(vertex.sites);
        }
    }

    void add_faces() {
        cell_.faces.reserve(diagram_.face_forms.size());
        for (const FaceId id : diagram_.face_forms.ids()) {
            const FormId form = diagram_.face_forms[id];
            if (!form.valid()) continue;
            CellFace& face = append_new(cell_.faces);
            face.site = of_.main_site(form);
            face.extra_sites.assign(problem_.sites[form].begin() + 1, problem_.sites[form].end());
            face.bisector = bisector_name(problem_, form);
            face.patches = std::move(surfaces_.of(id));
        }
    }

    void add_edges() {
        cell_.edges.reserve(diagram_.edges.size());
        positions_.reserve(diagram_.edges.size());
        for (const EdgeId e : diagram_.edges.ids()) {
            CellEdge& edge = append_new(cell_.edges);
            edge.sites = of_.sites(e);
            for (const FormId f : diagram_.label(e))
                for (const Site site : problem_.sites[f])
                    if (site != edge.sites[0] && site != edge.sites[1]) edge.extra_sites.push_back(site);
            sort_unique(edge.extra_sites);
            if (curves_.is_line(e) && !diagram_.edges[e].on_rim()) add_generator_ties(e, edge);
            if (curves_.has_ends(e)) edge.vertices = {diagram_.start(e).value, diagram_.end(e).value};
            edge.kind = equations_.kind(e);
            curves_.to_world(e, problem_.frame, edge.curve);
            set_error(e, edge);
        }
    }

    // The trims are compared with the space curve on patches as computed, whose control points are rounded;
    // and all of it is moved back, as for vertices.
    void set_error(EdgeId e, CellEdge& edge) {
        const double origin = problem_.frame.origin.norm();
        double square = origin * origin, ends = 0;
        for (const Vector4d& p : edge.curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double far = std::sqrt(square), rounding = 16 * u * (far + origin);
        for (const std::uint32_t v : edge.vertices) ends = std::max(ends, cell_.vertices[v].error);
        const auto [off, trims] = errors_(e, ends, rounding);
        // Nothing of the cell is farther away than its box, which holds the base.
        const double most = 4 * far;
        if (surfaces_.rounding(e) > fits_.most_error())
            throw fits_.unproved(e, "rounding leaves few digits of their faces",
                                 edge.curve.points.front().head<3>());
        positions_.push_back(std::min(most, off + rounding));
        edge.error = std::min(most, std::max(off, trims) + surfaces_.rounding(e) + rounding);
    }

    // Two forms change places over one generator as the angle grows, and back over the other they have in
    // common.
    void add_generator_ties(EdgeId e, CellEdge& edge) {
        const Vector4d &from = curves_.from(e), &to = curves_.to(e);
        const bool is_upward = from.y() < to.y();
        const FormId left = diagram_.edges[e].left, right = diagram_.edges[e].right;
        bool is_decided = true;
        for (const RadialBaseProblem::GeneratorTie& tie : problem_.generator_ties) {
            if (tie.before != (is_upward ? left : right) || tie.after != (is_upward ? right : left)) continue;
            is_decided = is_decided && tie.is_decided;
            edge.extra_sites.push_back(tie.site);
            for (const VertexId v : {diagram_.start(e), diagram_.end(e)}) {
                auto& sites = cell_.vertices[v.value].sites;
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
        cell_.report.warnings.push_back("objects " + sites + ": taken to meet in one line through " +
                                        to_text(problem_.unit * problem_.frame.to_world(middle.head<3>())) +
                                        ", not told apart within " +
                                        to_text(problem_.unit * narrow_tie * middle.w()));
    }

    const RadialDiagram of_;
    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    Decisions decisions_;
    radial::EdgeEquations equations_;
    const radial::RadialVertices vertices_;
    radial::RadialCurves curves_;
    FaceLoops loops_;
    radial::FacePatches patches_;
    radial::EdgeFits fits_;
    radial::FaceSurfaces surfaces_;
    radial::EdgeErrors errors_;
    Cell cell_;
    IdVector<EdgeId, double> positions_;  // bounds on the distance of space curves from the true ones
};

}  // namespace

LiftedCell lift(const RadialBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance,
                bool with_measures) {
    return RadialLifter({problem, diagram}, tolerance).lift(with_measures);
}

}  // namespace vcell
