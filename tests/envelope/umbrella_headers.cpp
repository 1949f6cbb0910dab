// What users include compiles by itself, in any order; tests/install finds it installed.
#include "../../envelope/envelope.hpp"

#include "../../arrangement/arrangement.hpp"
#include "../../core/core.hpp"
#include "../../core/solver/roots/solver.hpp"
#include "../../primitives/primitives.hpp"
#include "../../vcell.hpp"
