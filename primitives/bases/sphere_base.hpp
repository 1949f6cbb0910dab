/// Sphere bases: the scene in canonical position. See radial_base.hpp.
#pragma once

#include <cstdint>

#include "radial_base.hpp"

namespace vcell {

/// What of the base ball the box has to contain: rays start in its centre.
enum class BallInBox : std::uint8_t { All, Centre };

/// radial_base_problem() of a scene whose base is this sphere.
RadialBaseProblem sphere_base_problem(const Scene& scene, const Sphere& base, double unit,
                                      BallInBox room = BallInBox::All);

}  // namespace vcell
