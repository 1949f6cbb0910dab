/// A curve the other way round.
#pragma once

#include <algorithm>

#include "bspline.hpp"

namespace vcell {

/// Over the same domain: t becomes domain_begin() + domain_end() - t.
template <int Dim>
RationalCurve<Dim> reversed(RationalCurve<Dim> curve) {
    std::reverse(curve.points.begin(), curve.points.end());
    const double sum = curve.domain_begin() + curve.domain_end();
    std::reverse(curve.knots.begin(), curve.knots.end());
    for (double& knot : curve.knots) knot = sum - knot;
    return curve;
}

}  // namespace vcell
