/// A trisector's component by its equations in space and distance.
#pragma once

#include <optional>
#include <vector>

#include "quadratic_form.hpp"

namespace vcell {

/// Three functions of the homogeneous coordinates (x, y, z, r, 1) that vanish on the component, linear ones
/// and quadratic ones: all points at distance r from all three objects, those of virtual branches included,
/// are their zeros or another component's. At an admissible distance r is between `least` and `most`, and
/// there are no virtual ones.
struct TrisectorEquations {
    std::vector<LinearFunction> linear;
    std::vector<QuadraticForm> quadratic;
    std::optional<Exact> least, most;
};

}  // namespace vcell
