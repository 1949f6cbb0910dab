/// Lower envelopes, and the cells made of them.
#pragma once

#include "cell.hpp"
#include "cell_changes.hpp"
#include "complete_measures.hpp"
#include "diagram/minimization_diagram.hpp"
#include "measures/clearance_places.hpp"
#include "point_query.hpp"
#include "trisector/trisector_curves.hpp"
#include "vertex_refinement.hpp"
#include "voronoi_cell.hpp"
#include "voronoi_diagram.hpp"
#include "whole/void_network.hpp"
