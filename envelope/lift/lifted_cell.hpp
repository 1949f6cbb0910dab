/// What a lift leaves to voronoi_cell().
#pragma once

#include "../../core/ids.hpp"
#include "../cell.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

struct LiftedCell {
    Cell cell;
    /// Bounds on the distances of the edges' space curves from the true edges. Their errors bound the trims,
    /// too, which may be far worse: of these nothing follows for where an edge is.
    IdVector<EdgeId, double> positions;
};

}  // namespace vcell
