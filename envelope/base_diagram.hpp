/// The minimization diagram of a problem, over any base.
#pragma once

#include <span>
#include <string>

#include "../primitives/bases/base_problem.hpp"
#include "diagram/minimization_diagram.hpp"

namespace vcell {

/// The lower envelope of a family over the base of its chart, over a plane and a cylinder within these sides.
/// Vertices over planes and spheres are settled.
MinimizationDiagram envelope_over(const FormFamily& family, std::span<const RegionSide> region,
                                  const EnvelopeOptions& options);

/// "objects 1, 2, 5: <what> (x, y, z), not told apart within w".
std::string message(const Assumption& a, const char* what, const BaseProblem& problem);

/// Throws UndecidedError, which names the objects, where forms tie along a curve.
MinimizationDiagram diagram_of(const BaseProblem& problem, const EnvelopeOptions& options);

}  // namespace vcell
