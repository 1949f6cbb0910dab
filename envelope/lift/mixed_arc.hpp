/// The arcs of a minimization diagram with a cylinder on a side, ready for output: conics exactly, all others
/// fitted in space (space_spline.hpp).
///
/// *Conics.* A plane, the vertical ones over the region's rim included, cuts a cylinder's bisector in a conic
/// [HE, Lemma 4]; so does every plane in which two bisectors agree (primitives/bisectors/height_conics.hpp).
/// With the plane n.X = k in the patch's coordinates (cylinder_patch.hpp), n = (n1, n2, nz) in the frame
/// about p0 and k0 = k - n.(p0, 0),
///
///     N(v) + u M(v) = 0,   M = eps N + kappa,   kappa = n1 + eps (nz H + k0),
///     N = nz f0 - k0 + (n2 + nz z1) v + B v^2,  B = nz z2 - n1 eps / 4:
///
/// u is a quotient of quadratics in v and mu = kappa / M, so the curve in space and its chart curve are
/// rational quadratics in v, and its trim (u, v) a rational cubic (edge_trims.hpp). Only the ends and bend =
/// B (v1 - v0)^2 / (2 kappa) enter. kappa is nz times the height of the plane over the apex, less the apex's;
/// it is taken from exact numbers, and 0 where the plane passes through the apex: then the arc lies on a
/// ruling. The chart curve has a focus in A and eccentricity |lambda grad g + d| / K for the plane's height
/// g, whose comparison with 1 names the conic.
///
/// *Errors.* Which of the three is the base does not matter to an arc: with the cylinder as the base, r the
/// distance from its axis, the other two are met where linear functions of (p, r) have their values, the base
/// plane where z - r does, or z - S d.(p - c) - K r around a cone, and conic_error.hpp has the distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../cell.hpp"
#include "cylinder_patch.hpp"
#include "cylinder_sectors.hpp"
#include "edge_curves.hpp"
#include "edge_trims.hpp"
#include "face_cut.hpp"
#include "face_loops.hpp"
#include "joined_spans.hpp"
#include "space_spline.hpp"

namespace vcell {

/// The plane nx x + ny y + nz z = k of canonical space, exact.
struct SectionPlane {
    Exact nx, ny, nz, k;
};

/// Empty for diagrams without cylinders.
class MixedArcs {
public:
    /// tolerance: length, the largest distance of a fitted arc from the true one. Throws UndecidedError, with
    /// sites and place, where no curve is proved to be the arc.
    MixedArcs(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, const FaceLoops& loops,
              double tolerance, unsigned threads);
    MixedArcs(const MixedArcs&) = delete;
    MixedArcs& operator=(const MixedArcs&) = delete;

    /// Is there a cylinder on a side of e?
    bool contains(EdgeId e) const {
        if (!curves_) return false;
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        return !diagram_.is_circular(edge.left) || (!edge.on_rim() && !diagram_.is_circular(edge.right));
    }
    /// Is a face beside the edge lifted? What is below the base on both sides, where rays do not reach, has
    /// no curve.
    bool is_lifted(EdgeId e) const { return !curves_ || is_lifted_.empty() || is_lifted_[e]; }
    /// Pre: there are cylinders, here and below.
    const EdgeCurves& curves() const { return *curves_; }
    CurveKind kind(EdgeId e) const { return kinds_[e]; }
    /// Makes the curve in world coordinates; extends `heights` by its heights.
    void set_curve(EdgeId e, const BaseFrame& frame, RationalCurve3& curve, Range& heights) const;
    /// Makes the trim on the left or, reversed, on the right, in the direction of the loop.
    void set_trim(EdgeId e, bool reversed, RationalCurve2& curve) const;
    /// Bounds on the distance from the true arc, its ends' errors included.
    struct Error {
        double curve = 0;  ///< of the curve
        double edge = 0;   ///< of the lifted trims on both sides, too
    };
    const Error& error(EdgeId e) const { return errors_[e]; }
    /// Pre: the face's form is a cylinder's, here and below.
    const CylinderFrame& frame(FaceId f) const { return sectors_->frame(f); }
    const CylinderSectors& sectors() const { return *sectors_; }
    /// The parts of a face that is cut, in the parameters of their sectors' patches; of others none.
    std::span<const CutPart> parts(FaceId f) const {
        const auto found = cut_.find(f);
        return found == cut_.end() ? std::span<const CutPart>() : found->second;
    }

private:
    std::optional<SectionPlane> plane_of(const PlaneBaseProblem& problem, EdgeId e) const;
    bool add_section(const PlaneBaseProblem& problem, EdgeId e);
    std::vector<Eigen::Vector4d> points_along(const PlaneBaseProblem& problem, EdgeId e,
                                              const SectionPlane& plane) const;
    double section_trims_error(EdgeId e, double off) const;
    bool is_beside_cylinder(EdgeId e, unsigned side) const;
    double vertex_error(VertexId v) const;
    double end_error(EdgeId e) const;
    void set_error(EdgeId e, double curve, double trims);
    SpaceSite space_site_beside(const PlaneBaseProblem& problem, EdgeId e, FormId f, unsigned side) const;
    void add_splines(const PlaneBaseProblem& problem, const std::vector<EdgeId>& edges, double tolerance,
                     unsigned threads);
    void fit_spline(const PlaneBaseProblem& problem, EdgeId e, double tolerance, FitEffort& effort);
    template <class Parameters>
    void set_part(const Parameters& parameters, const EdgePart& part, RationalCurve2& curve) const;
    std::uint32_t sector_of(FaceId face, EdgeId e, bool reversed, std::size_t span) const;
    std::vector<std::vector<BoundaryRun>> runs(const FaceLoops& loops, FaceId face) const;
    void cut(const PlaneBaseProblem& problem, const FaceLoops& loops, FaceId face, std::uint32_t& seams);

    const MinimizationDiagram& diagram_;
    std::optional<CylinderSectors> sectors_;
    std::map<FaceId, std::vector<CutPart>> cut_;
    IdVector<EdgeId, CurveKind> kinds_;
    IdVector<VertexId, Eigen::Vector4d> points_;
    IdVector<EdgeId, bool> is_lifted_;  // empty: all are
    std::optional<EdgeCurves> curves_;
    IdVector<EdgeId, Error> errors_;
};

}  // namespace vcell
