/// Traced curves {g = 0} and their x-monotone pieces.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "monotone_graph.hpp"

namespace vcell {

/// A curve {g = 0} that has been traced: a fitted spline and the radius of a band about it.
///
/// Of {g = 0} the band holds exactly one simple arc, which runs along the spline from end to end: its point
/// at each time is within `band` of the spline's. (A closed spline, whose ends are equal: one simple closed
/// curve.) g is smooth with non-zero gradient on it. The spline says only where to look: every piece of the
/// curve is proved anew from g.
struct TracedCurve {
    RationalCurve2 spline;
    double band = 0;  ///< chart units
    std::shared_ptr<const DefiningFunction> g;
};

/// Part of a traced curve from one turn or end to the next; equal pointers: the same place.
struct TracedPiece {
    TracedGraph graph;
    std::shared_ptr<const TracedPlace> left, right;
};

struct TracedPieces {
    std::vector<TracedPiece> pieces;  ///< in order along the curve
    std::vector<Eigen::Vector2d>
        assumed;  ///< where it was assumed how often the curve turns: once or not at all
};

/// The x-monotone pieces of a traced curve, from one end to the other. The ends of an arc are where it passes
/// the x of the spline's ends or, where it is steep, their y.
///
/// Turns are found with proof: where g_x has no zero, the curve is x = h(y) and turns where g_y changes its
/// sign along it, which happens once at most where the derivative of that has no zero. What 320 bits cannot
/// tell about vertical inflections and turns of higher order, and what is narrower than 2^-200 of the scale
/// of the coordinates, is assumed.
///
/// Throws InputError (Unsupported) where the run of the curve cannot be told: at singular points, along
/// stretches of x = const (add_line), at ends about which the curve bends within a few bands.
TracedPieces cut_traced_curve(const TracedCurve& curve);

}  // namespace vcell
