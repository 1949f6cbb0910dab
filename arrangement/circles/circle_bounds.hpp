/// What the first rung of the circle kernel shares: bounds on the errors of gradients that are taken near a
/// point, not in it. Included by the kernel's sources alone.
#pragma once

#include <cmath>

#include "circle_forms.hpp"

namespace vcell::kernel_bounds {

inline double cross(double ax, double ay, double bx, double by) { return ax * by - ay * bx; }

// Bound on the error of a gradient's component, taken at a place that is `error` away from the true point.
inline double gradient_error(const FormJet& j, double error) {
    return (j.eg + 2 * (std::abs(j.K) + j.eK) * error) * slop;
}

// Bound on the error of the cross or dot product of two such gradients: of either one's components, and two
// products and a sum.
inline double gradient_product_error(const FormJet& a, const FormJet& b, double error) {
    const double ea = gradient_error(a, error), eb = gradient_error(b, error);
    const double a1 = std::abs(a.gx) + std::abs(a.gy), b1 = std::abs(b.gx) + std::abs(b.gy);
    return (ea * b1 + eb * a1 + 2 * ea * eb + 4 * u * a1 * b1) * slop + tiny;
}

}  // namespace vcell::kernel_bounds
