/// The trims of edges: their curves (edge_curves.hpp) in the parameters of the patches on both sides.
///
/// A patch of any kind is asked for
///
///     line_trim(patch, from, to)     the parameters of a line's ends, given as (p, t)
///     conic_trim(patch, span)        the trim of a conic's span; of one degree on all of a patch
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "conic_span.hpp"
#include "edge_curves.hpp"
#include "joined_spans.hpp"
#include "patch_coordinate.hpp"

namespace vcell {

/// The trim where one of two coordinates is the tangent of half an angle, with a divisor D that is a square
/// along the conic, and the other one is linear: over a cylinder base by D = t + x, x along the patch's first
/// axis, as D (t - x) = z^2, and over a plane base beside a cylinder (cylinder_patch.hpp). So D is the square
/// of the linear function that has the roots of D at the ends, and divides the numerator. Together they have
/// degree three.
ConicTrim cubic_trim(const PatchCoordinates& coordinates, int angle, const ConicSpan& span);

/// Some of an edge's spans, counted in the direction of a loop.
struct EdgePart {
    EdgeId e;
    bool reversed;
    std::size_t first, last;
};

/// Makes the trim of a part of an edge on its left or, reversed, on its right, in the direction of the loop.
template <class Patch>
void set_trim(const EdgeCurves& curves, const Patch& patch, const EdgePart& part, RationalCurve2& curve) {
    const auto [e, reversed, first, last] = part;
    const std::size_t n = curves.size(e);
    if (curves.is_spline(e)) {
        begin_joined(curve, 5, n, first, last);
        for (std::size_t i = first; i < last; ++i) {
            const auto& points = curves.splines(e)[reversed ? n - 1 - i : i].points;
            for (int k = i == first ? 0 : 1; k < 6; ++k) {
                const int at = reversed ? 5 - k : k;
                curve.points.push_back({points(4 + 2 * reversed, at), points(5 + 2 * reversed, at), 1});
            }
        }
        return;
    }
    if (curves.is_line(e)) {
        begin_joined(curve, 1, 1);
        for (const Vec2& p : line_trim(patch, curves.from(e), curves.to(e)))
            curve.points.push_back({p.x(), p.y(), 1});
    } else {
        // Joined spans share their end's weight: a span's first point is the last one's, only its weight is
        // new.
        bool is_first = true;
        for (const ConicSpan& span : curves.conics(e).subspan(reversed ? n - last : first, last - first)) {
            const ConicTrim trim = conic_trim(patch, span);
            if (is_first) begin_joined(curve, trim.degree, n, first, last);
            const double scale = (is_first ? 1 : curve.points.back().z()) / trim.points[0].z();
            for (int k = is_first ? 0 : 1; k <= trim.degree; ++k) {
                const Eigen::Vector3d& p = trim.points[k];
                curve.points.push_back({p.x() / p.z(), p.y() / p.z(), scale * p.z()});
            }
            is_first = false;
        }
    }
    // The knots are uniform: only the order changes.
    if (reversed) std::reverse(curve.points.begin(), curve.points.end());
}

}  // namespace vcell
