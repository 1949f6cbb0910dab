/// Subdivisions of the plane by curves: topology, sweep, overlay, point location, and the predicates of
/// circles and lines (exact) and of curves of any mix (certified).
#pragma once

#include "circles/circle_arcs.hpp"
#include "circles/circle_kernel.hpp"
#include "curves/curve_arcs.hpp"
#include "dcel/dcel.hpp"
#include "sweep/arc_geometry.hpp"
#include "sweep/overlay.hpp"
#include "sweep/point_location.hpp"
#include "sweep/sweep.hpp"
