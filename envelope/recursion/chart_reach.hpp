/// How far the stereographic chart of a sphere has to reach so that one form is lowest all around its rim.
#pragma once

#include "../../primitives/forms/form_family.hpp"

namespace vcell {

/// How far from the middle the chart of a sphere has to reach: beyond it one form is certainly lowest. With
/// (x, y) = (x', y') / (x'^2 + y'^2) every form is f / (x^2 + y^2) with its constant and quadratic terms
/// exchanged, so the question is about a square |x'|, |y'| <= h; the chart reaches to 1 / h.
/// Returns 1 / h. Throws UndecidedError if no form is lowest around the pole.
double chart_reach(const FormFamily& family);

}  // namespace vcell
