/// Splines through proved curves, with a certified bound on their distance.
#pragma once

#include "../../curves/bspline.hpp"
#include "../curves/curve.hpp"

namespace vcell {

/// A piecewise cubic with continuous tangent directions; closed when the component is.
template <int M>
struct FittedCurve {
    RationalCurve<M> curve;  ///< triple knots, parameter near arc length
    /// Certified: no point of the spline is farther from the curve, none of the curve farther from the
    /// spline. Infinite where nothing could be proved.
    double error = 0;
};

/// Fits the image of a component of f = 0 under a map, adding spans until the error of each is at most the
/// tolerance or rounding errors prevail (compare `error`). Each span is the cubic Hermite interpolant of the
/// image at two points of the curve. f_and_image: f_0, ..., f_{N-1} and after them the M coordinates of the
/// image, in one callable because they tend to share subexpressions.
///
/// Error: let c be the cubic in the unknowns x of f over a span, parameter s in [0, 1], its axis coordinate
/// monotone. By Hermite's remainder |f(c(s))| is at most 1/384 of its fourth derivative plus what f o c and
/// its derivative are at the ends; the Jacobian of f around the span turns that into a bound on the distance
/// between c(s) and the point of the curve with the same axis coordinate, the only one in the tubes'
/// neighbourhood. The image adds the remainder of image o c and the image's Lipschitz constant times that
/// distance. Pre: component of a result for f.
template <int N, int M>
FittedCurve<M> fit_curve(const SmoothMap<N + 1, N + M>& f_and_image, const CurveComponent<N + 1>& component,
                         double tolerance);

/// Fits the component itself in its first M coordinates.
template <int N, int M>
FittedCurve<M> fit_curve(const CurveSystem<N>& f, const CurveComponent<N + 1>& component, double tolerance);

}  // namespace vcell
