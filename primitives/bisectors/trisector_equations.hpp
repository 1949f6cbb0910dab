/// A trisector's component by its equations in space and distance.
#pragma once

#include <array>
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
    /// Of base, a, b, how their distances are r: a ball or tube is at r + rho from its centre or axis, -1: at
    /// rho - r, as one within it or around it is; a plane at r along its normal, -1: against it. 0: a plane
    /// that has two sides over a base plane, as on lines and conics only.
    std::array<int, 3> sides{};
};

}  // namespace vcell
