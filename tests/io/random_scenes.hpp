/// Scenes at random whose cells' curves and patches are what parts of the check are tried on.
#pragma once

#include <random>

#include "../../primitives/objects/scene.hpp"

namespace vcell {

/// About a ball of radius 1/2, or over the plane z = 0, in the box from -2 to 2: balls of all radii from 0
/// on, some of them as large as the base, and planes that keep clear of the base.
Scene scene_about_ball(std::mt19937_64& rng, int balls, int planes);
Scene scene_over_plane(std::mt19937_64& rng, int balls, int planes);

}  // namespace vcell
