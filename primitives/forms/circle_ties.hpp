/// Over a sphere: which balls and planes tie with two others all along a circle, and are nowhere nearer than
/// both.
///
/// In terms of the unit normal u a circular form is b.u + e: a point (b, e) of a space of four dimensions.
/// Three that tie all along a circle differ by multiples of one function, so they lie on a line there, and
/// the one between the others is their mean with positive weights: at each u it is no lower than the lower
/// one of them, and as low only where all three tie. So it is with two sides of the box and a ball whose
/// bisector runs through the edge between them, and with the centres of four balls of one radius, the base
/// among them, at the corners of a rectangle.
#pragma once

#include <array>
#include <vector>

#include "form_family.hpp"

namespace vcell {

struct CircleTie {
    FormId form;
    std::array<FormId, 2> between;  ///< `form` is a mean of these, with weights greater than zero
};

/// Ties of that kind among the 32 circular forms that come lowest, exact. Where coefficients agree in all but
/// their last digits some may be left out. Pre: the family is a sphere's.
std::vector<CircleTie> find_circle_ties(const FormFamily& family);

}  // namespace vcell
