/// Subdivisions of the plane by curves: topology and exact predicates.
#pragma once

#include "circle_kernel.hpp"
#include "dcel.hpp"
