// All umbrella headers: what they include is installed with them.
#include <vcell/arrangement/arrangement.hpp>
#include <vcell/core/core.hpp>
#include <vcell/core/solver/roots/solver.hpp>
#include <vcell/envelope/envelope.hpp>
#include <vcell/io.hpp>
#include <vcell/primitives/primitives.hpp>
