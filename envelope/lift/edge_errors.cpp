#include "edge_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "conic_error.hpp"
#include "conic_trim.hpp"

namespace vcell::radial {

using Eigen::Vector4d;

// The true edge ends in the true vertices, up to which the curve that was compared may be continued: their
// errors count twice.
EdgeErrors::Bounds EdgeErrors::operator()(EdgeId e, double ends, double rounding) const {
    if (curves_.is_spline(e)) return {curves_.fit_error(e).curve + ends, curves_.fit_error(e).trims};
    std::optional<std::array<DistancePlane, 2>> planes;
    if (!curves_.is_line(e)) planes = equations_.planes(e);
    const double off = planes ? conic_error(of_, curves_, e, *planes) + 2 * ends : ends;
    return {off, trims_error(e, off + 4 * rounding, planes)};
}

double conic_error(const RadialDiagram& of, const RadialCurves& curves, EdgeId e,
                   const std::array<DistancePlane, 2>& planes) {
    // The difference of forms that are nearly alike has all its digits, and tells the edge.
    constexpr double nearly_alike = 1 - 0x1p-33;
    const MinimizationDiagram::Edge& edge = of.diagram.edges[e];
    const Chart chart = of.problem.chart;
    if (curves.is_axial_conic(e))
        return conic_distance(curves.conics(e), curves.equations().axial_conic(e).planes_apart(), chart);
    if (!(std::abs(planes[0].normal.dot(planes[1].normal)) > nearly_alike))
        return conic_distance(curves.conics(e), planes, chart);
    return conic_distance(curves.conics(e), {planes[0], difference_plane(of.problem, edge.left, edge.right)},
                          chart);
}

// How far the trims of a line or conic are from it; off: what its points may be off the bisectors. The edge's
// planes are found where there are none yet.
double EdgeErrors::trims_error(EdgeId e, double off,
                               std::optional<std::array<DistancePlane, 2>>& planes) const {
    const MinimizationDiagram::Edge& edge = of_.diagram.edges[e];
    const bool is_circular = of_.diagram.is_circular(edge.left);  // over a cylinder no form is
    double most = off;
    if (curves_.is_line(e) && (is_circular || !equations_.axial(e))) return most;
    std::vector<ConicSpan> segment;
    std::span<const ConicSpan> along = curves_.conics(e);
    if (curves_.is_line(e)) {
        // The rays' slopes are those of one generator, best told far from the axis.
        const Vector4d &from = curves_.from(e), &to = curves_.to(e);
        const Vector4d& far = from.w() > to.w() ? from : to;
        segment.push_back({far, far, far, 1});
        along = segment;
    }
    for (const unsigned side : {0u, 1u}) {
        if (side == 1 && edge.on_rim()) continue;
        if (patches_.is_flat(side == 0 ? edge.left : edge.right)) continue;
        if (!of_.diagram.face_forms[of_.diagram.face(e, of_.diagram.side_of(e, side))].valid()) continue;
        if (!planes) planes = equations_.planes(e);
        // Rays that graze the bisector tell little of where a point of it is.
        constexpr double grazing = 64;
        const double gain = ray_gain(along, (*planes)[side], of_.problem.chart, off);
        double trim = (1 + gain) * off;
        if (gain > grazing && !curves_.is_line(e)) trim = std::min(trim, trim_distance_of(e, side, along));
        most = std::max(most, trim);
    }
    return most;
}

double EdgeErrors::trim_distance_of(EdgeId e, unsigned side, std::span<const ConicSpan> along) const {
    const FaceId face = of_.diagram.face(e, side);
    double most = 0;
    for (const ConicSpan& span : along) {
        const RadialPatch& patch = patches_.patch_at(face, span.half_way());
        using Kind = RadialPatch::Kind;
        constexpr std::array told{Kind::Planar, Kind::Stereographic, Kind::Confocal, Kind::AboutBase};
        if (std::ranges::find(told, patch.kind()) == told.end()) return infinity;
        most = std::max(most, trim_distance(patch, span, conic_trim(patch, span)));
    }
    return most;
}

}  // namespace vcell::radial
