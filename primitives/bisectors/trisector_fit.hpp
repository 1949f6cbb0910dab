/// Splines through the curves of trisectors that the solver has proved.
#pragma once

#include <array>

#include "../../core/curves/bspline.hpp"
#include "../../core/solver/curves/curve.hpp"
#include "../objects/objects.hpp"

namespace vcell {

/// A spline of degree 5, closed where its curve is.
struct TrisectorSpline {
    RationalCurve3 curve;  ///< knots of multiplicity 5, parameter near arc length
    /// Certified: no point of the spline is farther from the curve, none of the curve farther from the
    /// spline. Infinite where nothing could be proved.
    double error = 0;
};

/// Fits a component by the fit of cells' edges (primitives/fit/spline_fit.hpp), with the component's tubes as
/// its guide. `objects`: base, a, b, as seen from `sides` (trisector_equations.hpp). Pre: f vanishes where
/// the distances from all three are x[3], in terms of x, y, z; the component is of a result for f.
TrisectorSpline fit_trisector(const std::array<const Object*, 3>& objects, const std::array<int, 3>& sides,
                              const CurveSystem<3>& f, const CurveComponent<4>& component, double tolerance);

}  // namespace vcell
