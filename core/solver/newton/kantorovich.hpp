/// The theorem of Newton and Kantorovich, for kernels that bound a step by hand.
#pragma once

#include <cfloat>
#include <optional>

#include "../../platform.hpp"

namespace vcell {

/// With |J(p)^-1 f(p)| <= eta and |J(p)^-1 (J(q) - J(p))| <= omega |q - p|: if omega eta <= 1/4, f has
/// exactly one root within 1 / omega of p and J is regular there, and the root lies within the radius
/// returned [Deuflhard04, Thm. 2.1]: (1 - sqrt(1 - 2 h)) / omega <= (1 + h) eta, h = omega eta, rounded up.
/// None where nothing is proved; eta and omega are bounds, with all their rounding.
inline std::optional<double> kantorovich_radius(double eta, double omega) {
    const double h = omega * eta;
    if (!(h <= 0.25 * (1 - 4 * DBL_EPSILON)) || !(eta < DBL_MAX)) return std::nullopt;
    return (1 + h) * eta * (1 + 4 * DBL_EPSILON) + DBL_MIN;
}

}  // namespace vcell
