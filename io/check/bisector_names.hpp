/// What the bisector of base and site may be called.
#pragma once

#include <string>
#include <vector>

#include "../../primitives/objects/scene.hpp"

namespace vcell::check {

/// Several names where only exact arithmetic could tell. `scale`: of the scene's coordinates.
std::vector<std::string> bisector_names(const Scene& scene, const Site& s, double scale);

}  // namespace vcell::check
