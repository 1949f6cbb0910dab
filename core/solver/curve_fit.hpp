/// Splines through proved curves, with a certified bound on their distance.
#pragma once

#include "../bspline.hpp"
#include "curve.hpp"

namespace vcell {

/// A piecewise cubic with continuous tangent directions; closed when the component is.
template <int M>
struct FittedCurve {
    RationalCurve<M> curve;  ///< triple knots, parameter near arc length
    /// Certified: no point of the spline is farther from the curve, none of the curve farther from the
    /// spline. Infinite where nothing could be proved.
    double error = 0;
};

/// Fits the image of a component under `lift`, adding spans until each error is at most the tolerance or
/// rounding errors prevail (compare `error`). Each span is the cubic Hermite interpolant of the image at two
/// points of the curve.
///
/// Error: let c be the cubic of the chart (the unknowns of f) on a span, parameter s in [0, 1], its axis
/// coordinate monotone. By Hermite's remainder |f(c(s))| <= max |(f o c)''''| / 384 plus what f o c and its
/// derivative are at the ends; the Jacobian of f over the tube turns it into a bound on the distance between
/// c(s) and the point of the curve with the same axis coordinate. The image adds the remainder of lift o c
/// and the lift's Lipschitz constant times that distance. Pre: component of a result for f.
template <int N, int M>
FittedCurve<M> fit_curve(const CurveSystem<N>& f, const CurveComponent<N + 1>& component,
                         const SmoothMap<N + 1, M>& lift, double tolerance);

/// Fits the component itself in its first M coordinates.
template <int N, int M>
FittedCurve<M> fit_curve(const CurveSystem<N>& f, const CurveComponent<N + 1>& component, double tolerance);

}  // namespace vcell
