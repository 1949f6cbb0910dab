/// vcell: the Voronoi cell of one object among others, as trimmed rational patches, exact.
///
/// Users include this header and link vcell::vcell. It is what computing a cell takes; what the cell is made
/// with has a header for each module, among them <vcell/primitives/primitives.hpp> (bisectors, the bases'
/// problems), <vcell/arrangement/arrangement.hpp>, <vcell/core/solver/roots/solver.hpp> (systems of
/// equations) and <vcell/envelope/envelope.hpp> (minimization diagrams).
#pragma once

#include "core/platform.hpp"

#include "core/errors.hpp"
#include "envelope/cell.hpp"
#include "envelope/cell_changes.hpp"
#include "envelope/complete_measures.hpp"
#include "envelope/point_query.hpp"
#include "envelope/trisector/trisector_curves.hpp"
#include "envelope/voronoi_cell.hpp"
#include "envelope/voronoi_diagram.hpp"
#include "envelope/whole/void_network.hpp"
#include "primitives/objects/scene.hpp"
