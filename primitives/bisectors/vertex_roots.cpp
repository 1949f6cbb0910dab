#include "vertex_roots.hpp"

namespace vcell {

template Solutions<4> solve(const VertexSystem&, const IntervalBox<4>&, const SolverOptions&);

}  // namespace vcell
