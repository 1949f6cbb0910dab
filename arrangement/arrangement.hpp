/// Subdivisions of the plane by curves: topology, sweep, overlay, point location, and the predicates of
/// circles and lines (exact) and of curves of any mix (certified).
#pragma once

#include "arc_geometry.hpp"
#include "circle_arcs.hpp"
#include "circle_kernel.hpp"
#include "dcel.hpp"
#include "mixed_arcs.hpp"
#include "overlay.hpp"
#include "point_location.hpp"
#include "sweep.hpp"
