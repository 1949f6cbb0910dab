/// The arcs of a minimization diagram with a cylinder on a side, ready for output: conics exactly, all others
/// fitted in space (space_spline.hpp).
///
/// *Conics.* A plane, the vertical ones over the region's rim included, cuts a cylinder's bisector in a conic
/// [HE, Lemma 4]; so does every plane in which two bisectors agree (primitives/bisectors/height_conics.hpp).
/// With the plane n.X = k in the patch's coordinates (cylinder_patch.hpp), n = (n1, n2, nz) in the frame
/// about p0 and k0 = k - n.(p0, 0),
///
///     N(v) + u M(v) = 0,   M = eps N + kappa,   kappa = n1 + eps (nz rho + k0),
///     N = nz f0 - k0 + (n2 + nz z1) v + B v^2,  B = nz z2 - n1 eps / 4:
///
/// u is a quotient of quadratics in v and mu = kappa / M, so the curve in space and its chart curve are
/// rational quadratics in v, and its trim (u, v) a rational cubic. Only the ends and bend = B (v1 - v0)^2 /
/// (2 kappa) enter. kappa is nz times the height of the plane over the apex, less the apex's; it is taken
/// from exact numbers, and 0 where the plane passes through the apex: then the arc lies on a ruling. The
/// chart curve has a focus in A and eccentricity |d_z grad g + d| for the plane's height g, whose comparison
/// with 1 names the conic.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../cell.hpp"
#include "joined_spans.hpp"
#include "mixed_span.hpp"
#include "section_error.hpp"
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
    MixedArcs(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance);

    /// Is there a cylinder on a side of e?
    bool contains(EdgeId e) const { return !offsets_.empty() && offsets_[e.value] < offsets_[e.value + 1]; }
    /// In the direction of half-edge 2e, all of one degree.
    std::span<const MixedSpan> spans(EdgeId e) const {
        return {spans_.data() + offsets_[e.value], spans_.data() + offsets_[e.value + 1]};
    }
    CurveKind kind(EdgeId e) const { return arcs_[e].kind; }
    /// Makes the curve in world coordinates; extends `heights` by its heights.
    void set_curve(EdgeId e, const BaseFrame& frame, RationalCurve3& curve, Range& heights) const;
    /// Makes the trim on the left or, reversed, on the right, in the direction of the loop.
    void set_trim(EdgeId e, bool reversed, RationalCurve2& curve) const;
    /// Bounds on the distance from the true arc, its ends' errors included.
    const FitError& error(EdgeId e) const { return arcs_[e].error; }
    /// Pre: the face's form is a cylinder's.
    const CylinderFrame& frame(FaceId f) const { return frames_[f]; }

private:
    struct Arc {
        CurveKind kind = CurveKind::Spline;
        FitError error;
    };

    void add_frames(const PlaneBaseProblem& problem);
    void add_edge(const PlaneBaseProblem& problem, EdgeId e, double tolerance);
    std::optional<SectionPlane> plane_of(const PlaneBaseProblem& problem, EdgeId e) const;
    bool add_section(const PlaneBaseProblem& problem, EdgeId e);
    ArcSide arc_side(EdgeId e, FormId f, unsigned side) const;
    void add_end_errors(EdgeId e);
    SpaceSite space_site_beside(const PlaneBaseProblem& problem, EdgeId e, FormId f, unsigned side) const;
    void add_spline(const PlaneBaseProblem& problem, EdgeId e, double tolerance);

    const MinimizationDiagram& diagram_;
    FitEffort effort_;
    IdVector<FaceId, CylinderFrame> frames_;
    std::vector<MixedSpan> spans_;
    std::vector<std::uint32_t> offsets_;
    IdVector<EdgeId, Arc> arcs_;
};

}  // namespace vcell
