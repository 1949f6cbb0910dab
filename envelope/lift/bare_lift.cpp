// Around a sphere edges are found before the patches are, and measures take nothing else.
#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "../measures/measures.hpp"
#include "based_diagram.hpp"
#include "cell_assembly.hpp"
#include "edge_equations.hpp"
#include "edge_errors.hpp"
#include "radial_curves.hpp"
#include "radial_vertices.hpp"
#include "sphere_arcs.hpp"

namespace vcell {

namespace {

using roundoff::u;

class BareLift {
public:
    BareLift(const RadialDiagram& of)
        : of_(of),
          origin_(of.problem.frame.origin.norm()),
          equations_(of),
          vertices_(of, equations_),
          curves_(of, vertices_, equations_) {
        add_sphere_arcs(of_, equations_, curves_, decisions_);
    }

    const RadialDiagram& of() const { return of_; }
    Decisions decisions() const {
        Decisions sum = equations_.decisions();
        return sum += decisions_;
    }

    LiftedVertex vertex(VertexId v) const {
        return {vertices_.point(v), vertices_[v].w() - of_.problem.chart.radius, vertices_.error(v)};
    }
    void add_rim_sites(VertexId, SmallVector<Site, 4>&) const {}  // a sphere has none
    std::string_view bisector(FormId) const { return {}; }
    void set_patches(FaceId, std::vector<TrimmedPatch>&) const {}
    CurveKind kind(EdgeId e) const { return equations_.kind(e); }

    // As the edge's error with patches (EdgeErrors), without its trims.
    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) {
        curves_.to_world(e, of_.problem.frame, curve);
        double square = origin_ * origin_;
        for (const Eigen::Vector4d& p : curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double far = std::sqrt(square), rounding = 16 * u * (far + origin_);
        const double error = std::min(4 * far, off(e, ends) + rounding);
        return {error, error};
    }

    void finish(Cell&) const {}
    void measure(const IdVector<EdgeId, double>& positions, Cell& cell) const {
        measure_all_around(of_.problem, of_.diagram, positions, cell);
    }

private:
    // How far the curve may be from the true edge, without rounding of what is moved back.
    double off(EdgeId e, double ends) {
        return curves_.is_line(e) ? ends
                                  : radial::conic_error(of_, curves_, e, equations_.planes(e)) + 2 * ends;
    }

    const RadialDiagram of_;
    const double origin_;  // how far the frame's is from the world's
    Decisions decisions_;
    radial::EdgeEquations equations_;
    const radial::RadialVertices vertices_;
    radial::RadialCurves curves_;
};

}  // namespace

LiftedCell lift_without_patches(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                double tolerance, bool with_measures) {
    // Over a cylinder no form is circular.
    if (!problem.family.is_all_circular()) return lift_all_around(problem, diagram, tolerance, with_measures);
    BareLift lift({problem, diagram});
    return CellAssembly(lift)(with_measures);
}

}  // namespace vcell
