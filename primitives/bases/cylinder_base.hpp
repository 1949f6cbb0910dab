/// Cylinder bases: the scene in canonical position. See radial_base.hpp.
#pragma once

#include "radial_base.hpp"

namespace vcell {

/// radial_base_problem() of a scene whose base is this cylinder.
RadialBaseProblem cylinder_base_problem(const Scene& scene, const Cylinder& base, double unit);

}  // namespace vcell
