/// The arcs of circular forms over a sphere base as conics in space.
#pragma once

#include "based_diagram.hpp"
#include "edge_equations.hpp"
#include "radial_curves.hpp"

namespace vcell::radial {

/// Makes the conics of all edges between circular forms that are no lines. Returns the signs that are taken.
Decisions add_sphere_arcs(const RadialDiagram& of, RadialCurves& curves, unsigned threads);

}  // namespace vcell::radial
