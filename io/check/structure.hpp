/// Structure: what must hold before anything of a cell can be evaluated. Indices, counts, knots, weights.
#pragma once

#include "../../envelope/cell.hpp"
#include "certificate.hpp"
#include "scene.hpp"

namespace vcell::check {

/// Pre: the geometry is that of the cell's scene. Nothing is refuted: all of the cell may be evaluated.
void certify_structure(const Cell& cell, const SceneGeometry& geometry, Certificate& certificate);

}  // namespace vcell::check
