/// Sphere bases: the scene in canonical position. See radial_base.hpp.
#pragma once

#include "radial_base.hpp"

namespace vcell {

/// radial_base_problem() of a scene whose base is this sphere.
RadialBaseProblem sphere_base_problem(const Scene& scene, const Sphere& base, double unit);

}  // namespace vcell
