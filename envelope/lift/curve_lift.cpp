// Curves of edges between objects around a sphere or a cylinder, before faces have patches: these may be of
// any shape.
#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "based_diagram.hpp"
#include "cell_assembly.hpp"
#include "edge_equations.hpp"
#include "edge_errors.hpp"
#include "edge_fits.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"
#include "radial_curves.hpp"
#include "radial_vertices.hpp"
#include "sphere_arcs.hpp"

namespace vcell {

namespace {

using roundoff::u;

class CurveLift {
public:
    CurveLift(const RadialDiagram& of, double tolerance)
        : of_(of),
          origin_(of.problem.frame.origin.norm()),
          equations_(of),
          vertices_(of, equations_),
          curves_(of, vertices_, equations_),
          loops_(of.diagram),
          patches_(of, loops_, curves_, false),
          fits_(of, patches_, curves_, tolerance) {
        add_sphere_arcs(of_, equations_, curves_, decisions_);
        std::vector<EdgeId> to_fit;
        for (const EdgeId e : of_.diagram.edges.ids())
            if (is_wanted(e) && fits_.is_asked_for(e)) to_fit.push_back(e);
        fits_.grant(to_fit.size());
        for (const EdgeId e : to_fit) fits_.fit(e);
        if (fits_.refine())
            for (const EdgeId e : to_fit) fits_.fit(e);
        for (const EdgeId e : to_fit) fits_.require_proof(e);
    }

    const RadialDiagram& of() const { return of_; }
    Decisions decisions() const {
        Decisions sum = equations_.decisions();
        return sum += decisions_;
    }

    LiftedVertex vertex(VertexId v) const {
        return {vertices_.point(v), vertices_[v].w() - of_.problem.chart.radius, vertices_.error(v)};
    }
    void add_rim_sites(VertexId v, SmallVector<Site, 4>& sites) const { of_.add_rim_sites(v, sites); }
    std::string_view bisector(FormId) const { return {}; }
    void set_patches(FaceId, std::vector<TrimmedPatch>&) const {}
    CurveKind kind(EdgeId e) const { return equations_.kind(e); }

    // As the edge's error with patches (EdgeErrors), without its trims.
    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) {
        if (!is_wanted(e)) return {0, 0};
        curves_.to_world(e, of_.problem.frame, curve);
        double square = origin_ * origin_;
        for (const Eigen::Vector4d& p : curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double far = std::sqrt(square), rounding = 16 * u * (far + origin_);
        const double error = std::min(4 * far, off(e, ends) + rounding);
        return {error, error};
    }

    void finish(Cell&) const {}
    void measure(const IdVector<EdgeId, double>&, Cell&) const {}

private:
    bool is_wanted(EdgeId e) const {
        return std::ranges::count_if(of_.diagram.label(e),
                                     [&](FormId f) { return of_.main_site(f).is_object(); }) >= 2;
    }

    double off(EdgeId e, double ends) {
        if (curves_.is_spline(e)) return curves_.fit_error(e).curve + ends;
        return curves_.is_line(e) ? ends
                                  : radial::conic_error(of_, curves_, e, equations_.planes(e)) + 2 * ends;
    }

    const RadialDiagram of_;
    const double origin_;  // how far the frame's is from the world's
    Decisions decisions_;
    radial::EdgeEquations equations_;
    const radial::RadialVertices vertices_;
    radial::RadialCurves curves_;
    FaceLoops loops_;
    radial::FacePatches patches_;
    radial::EdgeFits fits_;
};

}  // namespace

LiftedCell lift_curves_between_objects(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                       double tolerance) {
    CurveLift lift({problem, diagram}, tolerance);
    return CellAssembly(lift)(false);
}

}  // namespace vcell
