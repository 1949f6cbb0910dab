/// vcell: the Voronoi cell of one object among others, as trimmed rational patches, exact.
/// Users include this header and link vcell::vcell.
#pragma once

#include "core/platform.hpp"

#include "arrangement/arrangement.hpp"
#include "core/core.hpp"
#include "core/solver/fit/curve_fit.hpp"
#include "core/solver/roots/solver.hpp"
#include "envelope/envelope.hpp"
#include "primitives/primitives.hpp"
