/// Areas and volumes of a ball's cell among balls, face by face, along the arcs of its diagram on the sphere.
///
/// The integrals are those of radial_integrals.hpp along the curve p = u / q(u), q = 1 / t. Where u runs on
/// an arc with control points U / W the curve has the control points U / Q: an arc's ends and the point where
/// its tangents meet are all that is evaluated. With S the closed integral of b.(p x dp) around a face,
///
///     c S / 6 = the volume between the face and the base's centre, and that between it and the neighbour's,
///
/// as both are a third of the integral of (x - centre).n. So a face that is measured in one cell is measured
/// in the other one, too.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "../../primitives/bases/radial_base.hpp"
#include "../sphere/disc_arcs.hpp"
#include "radial_integrals.hpp"

namespace vcell {

/// What the arcs around a face tell of it.
struct FaceMeasures {
    Integral area;
    Integral volume;  ///< of the part of the base's cell that is seen through the face, body included
    Integral both;    ///< with that of the neighbour's cell. Pre: the face is no wall's
};

struct ArcMeasures {
    std::vector<FaceMeasures> faces;  ///< as DiscArcs::faces; zero where it was not asked about
    /// From the base's centre; `most` within its error, `least` to rounding.
    double least = std::numeric_limits<double>::infinity(), most = 0, most_error = 0;
};

/// Measures the faces that `is_asked` names, by their places, and the distances of all. False where that is
/// no common case: digits are too few for bounds of first order. Errors: truncation proven
/// (core/quadrature/quadrature.hpp), rounding and what errors of the arcs change to first order, doubled.
/// Pre: `arcs` are of the problem's forms, which are balls and walls, in coordinates that chart.turn turns
/// into those of the problem.
bool measure_arcs(const RadialBaseProblem& problem, const DiscArcs& arcs, const std::vector<char>& is_asked,
                  ArcMeasures& measures);

}  // namespace vcell
