/// All vertices of four objects in a box, by the solver.
#pragma once

#include "../../core/solver/roots/solver.hpp"
#include "vertex_system.hpp"

namespace vcell {

extern template Solutions<4> solve(const VertexSystem&, const IntervalBox<4>&, const SolverOptions&);

}  // namespace vcell
