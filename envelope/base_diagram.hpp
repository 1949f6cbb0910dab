/// The minimization diagram of a problem, over any base.
#pragma once

#include <string>

#include "../primitives/bases/plane_base.hpp"
#include "../primitives/bases/radial_base.hpp"
#include "diagram/minimization_diagram.hpp"

namespace vcell {

/// "objects 1, 2, 5: <what> (x, y, z), not told apart within w".
std::string message(const Assumption& a, const char* what, const PlaneBaseProblem& problem);
std::string message(const Assumption& a, const char* what, const RadialBaseProblem& problem);

/// Vertices are settled. Throws UndecidedError, which names the objects, where forms tie along a curve.
MinimizationDiagram diagram_of(const PlaneBaseProblem& problem, const EnvelopeOptions& options);
MinimizationDiagram diagram_of(const RadialBaseProblem& problem, const EnvelopeOptions& options);

}  // namespace vcell
