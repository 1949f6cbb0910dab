/// How far the edges over a sphere or a cylinder base, as written, may be from the true ones.
#pragma once

#include <optional>
#include <span>

#include "../cell.hpp"
#include "based_diagram.hpp"
#include "edge_equations.hpp"
#include "edge_fits.hpp"
#include "face_patches.hpp"
#include "face_surfaces.hpp"
#include "radial_curves.hpp"

namespace vcell::radial {

class EdgeErrors {
public:
    EdgeErrors(const RadialDiagram& of, const EdgeEquations& equations, const RadialCurves& curves,
               const FacePatches& patches)
        : of_(of), equations_(equations), curves_(curves), patches_(patches) {}

    struct Bounds {
        double curve;  ///< bounds the distance from the true edge
        double trims;  ///< bounds how far the patches' points at the trims are from the curve
    };
    /// ends: a bound on the errors of an edge's vertices; rounding: of its points, and of their motion.
    Bounds operator()(EdgeId e, double ends, double rounding) const;

private:
    double trims_error(EdgeId e, double off, std::optional<std::array<DistancePlane, 2>>& planes) const;
    double trim_distance_of(EdgeId e, unsigned side, std::span<const ConicSpan> along) const;

    const RadialDiagram of_;
    const EdgeEquations& equations_;
    const RadialCurves& curves_;
    const FacePatches& patches_;
};

/// A bound on the distance of a conic's curve from the true edge up to its ends, from the planes of both
/// sites.
double conic_error(const RadialDiagram& of, const RadialCurves& curves, EdgeId e,
                   const std::array<DistancePlane, 2>& planes);

}  // namespace vcell::radial
