/// The curves of edges that depend on their faces' patches: splines, whose trims are fitted with them, and
/// conics that are divided where they leave a sector over a cylinder, or a half of a face over a sphere.
#pragma once

#include <vector>

#include "based_diagram.hpp"
#include "face_patches.hpp"
#include "radial_curves.hpp"
#include "space_spline.hpp"

namespace vcell::radial {

class EdgeFits {
public:
    /// tolerance: length, of splines.
    EdgeFits(const RadialDiagram& of, const FacePatches& patches, RadialCurves& curves, double tolerance,
             unsigned threads)
        : of_(of), patches_(patches), curves_(curves), tolerance_(tolerance), threads_(threads) {}

    bool is_asked_for(EdgeId e) const {
        return !of_.is_bare(e) && (curves_.is_spline(e) || curves_.is_axial_conic(e) || is_beside_halves(e));
    }
    /// Has a face with the edge halves? They have the trims of its conics in mind.
    bool is_beside_halves(EdgeId e) const { return halves(e, 0) != nullptr || halves(e, 1) != nullptr; }
    /// Lets so many more edges be fitted, each at the price of some spans.
    void grant(std::size_t edges) { effort_.spans += 500 * edges; }

    void fit(const std::vector<EdgeId>& edges);

    /// The box says little of how far the cell reaches, which may be less than the tolerance: curves have to
    /// be four digits finer than that. What the curves themselves say of it serves, coarse as they are.
    /// Lowers the tolerance, or false where it is as low.
    bool refine();
    double tolerance() const { return tolerance_; }
    /// Beyond this a bound says as good as nothing.
    double most_error() const { return 256 * tolerance_; }
    /// What is proved of a spline, its curve and trims together.
    double error(EdgeId e) const { return curves_.fit_error(e).curve + curves_.fit_error(e).trims; }

    /// A spline that is not proved to follow its arc is none.
    void require_proof(EdgeId e) const;

private:
    const SurfaceHalves* halves(EdgeId e, unsigned side) const {
        return patches_.halves(of_.diagram.face(e, side));
    }
    void fit_spline(EdgeId e, FitEffort& effort);
    void fit_axial_conic(EdgeId e);
    void divide_conic(EdgeId e);
    std::vector<double> angles_along(EdgeId e) const;

    const RadialDiagram of_;
    const FacePatches& patches_;
    RadialCurves& curves_;
    double tolerance_;
    const unsigned threads_;
    FitEffort effort_;
};

}  // namespace vcell::radial
