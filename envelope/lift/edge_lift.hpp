/// The vertices and curves of edges around a sphere or a cylinder: what a lift knows before faces have
/// patches.
#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "../measures/measures.hpp"
#include "based_diagram.hpp"
#include "cell_assembly.hpp"
#include "edge_equations.hpp"
#include "edge_errors.hpp"
#include "radial_curves.hpp"
#include "radial_vertices.hpp"
#include "ring_sites.hpp"
#include "sphere_arcs.hpp"

namespace vcell {

/// A Lift (cell_assembly.hpp) without patches, which those that have some extend. The conics
/// around a sphere are there from the beginning; splines and conics around a cylinder are fitted later.
class EdgeLift {
public:
    static constexpr bool is_shareable = true;

    EdgeLift(const RadialDiagram& of, unsigned threads)
        : of_(of),
          threads_(threads),
          origin_(of.problem.frame.origin.norm()),
          equations_(of, threads),
          vertices_(of, equations_, threads),
          curves_(of, vertices_, equations_),
          decisions_(add_sphere_arcs(of_, curves_, threads)) {}
    EdgeLift(const EdgeLift&) = delete;
    EdgeLift& operator=(const EdgeLift&) = delete;

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
    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) const {
        const auto [far, rounding] = set_world_curve(e, curve);
        const double error = std::min(4 * far, off(e, ends) + rounding);
        return {error, error};
    }

    void finish(Cell& cell) const { radial::add_ring_sites(of_, curves_, cell); }
    void measure(const IdVector<EdgeId, double>& positions, Cell& cell) const {
        measure_all_around(of_.problem, of_.diagram, positions, cell, threads_);
    }

protected:
    struct WorldCurve {
        double far;       // from the frame's origin or the world's, of the curve and all that is near it
        double rounding;  // of what is moved back to the world there
    };
    WorldCurve set_world_curve(EdgeId e, RationalCurve3& curve) const {
        curves_.to_world(e, of_.problem.frame, curve);
        double square = origin_ * origin_;
        for (const Eigen::Vector4d& p : curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double far = std::sqrt(square);
        return {far, 16 * roundoff::u * (far + origin_)};
    }

    const RadialDiagram of_;
    const unsigned threads_;
    const double origin_;  // how far the frame's is from the world's
    const radial::EdgeEquations equations_;
    const radial::RadialVertices vertices_;
    radial::RadialCurves curves_;
    Decisions decisions_;

private:
    // How far the curve may be from the true edge, without rounding of what is moved back.
    double off(EdgeId e, double ends) const {
        if (curves_.is_spline(e)) return curves_.fit_error(e).curve + ends;
        return curves_.is_line(e) ? ends
                                  : radial::conic_error(of_, curves_, e, equations_.planes(e)) + 2 * ends;
    }
};

}  // namespace vcell
