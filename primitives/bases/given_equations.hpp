/// The equations of objects as they were given, in X = (p, t, 1): p the place in the world, t its distance
/// from the base (../forms/space_quadrics.hpp).
#pragma once

#include <variant>
#include <vector>

#include "../forms/form_family.hpp"
#include "../objects/objects.hpp"
#include "base_problem.hpp"
#include "world_objects.hpp"

namespace vcell {

/// What a form is of: an object, a side of the box, which bounds the cell itself, or something else.
using GivenForm = std::variant<std::monostate, Object, WorldSide>;

/// Writes them for balls, tubes and sides around a tube; `frame` is that of the chart's own axes. Others have
/// none: the length of a plane's normal is no rational number, and the equation of a vessel has other roots.
FormFamily::GivenEquations given_equations(const Cylinder& base, const BaseFrame& frame,
                                           std::vector<GivenForm> forms);

}  // namespace vcell
