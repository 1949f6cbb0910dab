/// Sites that tie along edges around a cylinder without a face of their own (primitives/forms/ring_ties.hpp).
#pragma once

#include "../cell.hpp"
#include "based_diagram.hpp"
#include "radial_curves.hpp"

namespace vcell::radial {

/// Adds them to edges that two forms have on a ring on which they tie, and to those of the rim, and to the
/// ends of both. Two forms have an edge on the ring or on another one: its error is to tell which, or
/// UndecidedError is thrown. Pre: edges have theirs.
void add_ring_sites(const RadialDiagram& of, const RadialCurves& curves, Cell& cell);

}  // namespace vcell::radial
