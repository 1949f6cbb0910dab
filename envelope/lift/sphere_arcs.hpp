/// The arcs of circular forms over a sphere base as conics in space.
#pragma once

#include "based_diagram.hpp"
#include "edge_equations.hpp"
#include "radial_curves.hpp"

namespace vcell::radial {

/// Makes the conics of all edges between circular forms that are no lines. `decisions` counts the signs that
/// are taken.
void add_sphere_arcs(const RadialDiagram& of, EdgeEquations& equations, RadialCurves& curves,
                     Decisions& decisions);

}  // namespace vcell::radial
