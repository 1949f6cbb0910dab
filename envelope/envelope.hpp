/// Lower envelopes, and the cells made of them.
#pragma once

#include "cell.hpp"
#include "diagram/minimization_diagram.hpp"
#include "voronoi_cell.hpp"
