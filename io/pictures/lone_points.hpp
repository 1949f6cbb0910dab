/// Points of meshes that no triangle has.
#pragma once

#include "mesh.hpp"

namespace vcell {

/// Takes them out, with what is left of lines where no triangle has their points either. Those that stay keep
/// their order.
void drop_lone_points(CellMesh& mesh);

}  // namespace vcell
