#include "edge_fits.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "conic_trim.hpp"
#include "fit_all.hpp"
#include "joined_spans.hpp"

namespace vcell::radial {

using Eigen::Vector4d;

void EdgeFits::fit(const std::vector<EdgeId>& edges) {
    std::vector<EdgeId> splines;
    for (const EdgeId e : edges)
        if (curves_.is_axial_conic(e))
            fit_axial_conic(e);
        else if (curves_.is_spline(e))
            splines.push_back(e);
        else
            divide_conic(e);
    fit_all(splines.size(), effort_, threads_,
            [&](std::size_t i, FitEffort& effort) { fit_spline(splines[i], effort); });
}

void EdgeFits::fit_spline(EdgeId e, FitEffort& effort) {
    const RadialBaseProblem& problem = of_.problem;
    const MinimizationDiagram::Edge& edge = of_.diagram.edges[e];
    const RadialVertices& vertices = curves_.vertices();
    const bool is_turned = of_.diagram.side_of(e, 0) == 1;  // the left form has the face on the right
    SpaceArc arc{{patches_.site(e, is_turned ? 1 : 0), {}},
                 vertices.end(of_.diagram.start(e)),
                 vertices.end(of_.diagram.end(e)),
                 of_.diagram.pieces(e)};
    arc.is_turned = is_turned;
    if (edge.on_rim()) {
        arc.sites[1] = end_wall(problem, edge.side);
        arc.turn = std::abs(patches_.turns().along(e)[1]);
    } else {
        arc.sites[1] = patches_.site(e, is_turned ? 0 : 1);
        arc.sites_cross = problem.cross_equally(edge.left, edge.right);
        if (const auto twins = twin_quadric(problem.family, edge.right, edge.left))
            arc.twins = twins->turned(problem.chart.turn);
    }
    curves_.set_spline(e, [&](std::vector<SpaceSpan>& spans) {
        return fit_space_spline(problem.chart, arc, tolerance_, spans, effort);
    });
}

// Through the angles of the chart over its start, over where it leaves a sector, and over its end.
void EdgeFits::fit_axial_conic(EdgeId e) {
    const AxialConic conic = curves_.equations().axial_conic(e);
    const std::vector<double> angles = angles_along(e);
    const auto at = [&](double angle) { return conic.at(patches_.turns().direction(angle)); };
    Vector4d from = curves_.has_ends(e) ? curves_.from(e) : at(angles.front());
    const Vector4d last = curves_.has_ends(e) ? curves_.to(e) : from;
    curves_.set_conics(e, [&](std::vector<ConicSpan>& spans) {
        for (std::size_t i = 1; i < angles.size(); ++i) {
            const Vector4d to = i + 1 == angles.size() ? last : at(angles[i]);
            add_even(conic.between(from, to), spans);
            from = to;
        }
    });
}

// Monotonic, as the conic has one point over every angle. An end so near to a seam counts as on it.
std::vector<double> EdgeFits::angles_along(EdgeId e) const {
    constexpr double widest = std::numbers::pi / 3, near = 0x1p-32;
    const auto [from, turn] = patches_.turns().along(e);
    std::vector<double> parts;
    const auto count = static_cast<int>(std::ceil(std::abs(turn) / widest));
    for (int i = 1; i < count; ++i) parts.push_back(std::abs(turn) * i / count);
    for (const unsigned side : {0u, 1u})
        for (const Sector& s : patches_.sectors(of_.diagram.face(e, side))) {
            const double part = turned_until(s.from(), from, turn);
            if (part > near && part < std::abs(turn) - near) parts.push_back(part);
        }
    sort_unique(parts);
    std::vector<double> angles{from};
    for (const double part : parts) angles.push_back(from + std::copysign(part, turn));
    angles.push_back(from + turn);
    return angles;
}

void EdgeFits::divide_conic(EdgeId e) {
    std::vector<ConicSpan> spans(curves_.conics(e).begin(), curves_.conics(e).end()), divided;
    for (const unsigned side : {0u, 1u})
        if (const SurfaceHalves* two = halves(e, side)) {
            for (const ConicSpan& span : spans) two->add_divided(span, divided);
            spans = std::exchange(divided, {});
        }
    std::vector<const RadialPatch*> patches;
    curves_.set_conics(e, [&](std::vector<ConicSpan>& result) {
        for (const ConicSpan& span : spans) {
            patches.clear();
            for (const unsigned side : {0u, 1u})
                if (const FaceId face = of_.diagram.face(e, side); of_.diagram.face_forms[face].valid())
                    patches.push_back(&patches_.patch_at(face, span.half_way()));
            add_halves(span, patches, result);
        }
    });
}

bool EdgeFits::refine() {
    const double fine = 1e-4 * std::max(curves_.vertices().reach(), curves_.reach());
    if (!(fine < tolerance_ && fine > 0)) return false;
    tolerance_ = fine;
    return true;
}

void EdgeFits::require_proof(EdgeId e) const {
    if (!curves_.is_spline(e) || of_.is_bare(e) || error(e) <= most_error()) return;
    const SpaceFitError& error = curves_.fit_error(e);
    throw of_.unproved(e, "no curve is proved to be the one between them",
                       of_.problem.frame.to_world(error.unproved.value_or(error.worst)));
}

}  // namespace vcell::radial
