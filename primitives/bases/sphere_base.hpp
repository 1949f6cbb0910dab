/// Sphere bases: the scene in canonical position. See radial_base.hpp.
#pragma once

#include <optional>

#include "radial_base.hpp"

namespace vcell {

/// radial_base_problem() of a scene whose base is this sphere.
RadialBaseProblem sphere_base_problem(const Scene& scene, const Sphere& base, double unit,
                                      std::optional<double> probe = std::nullopt);

}  // namespace vcell
