/// Cylinders of one radius whose axes cross in a point.
///
/// The points as far from one axis as from the other make up two planes, which cross in the line through that
/// point across both axes. There the trisector of both cylinders and the base has a node: distances agree,
/// and so do their gradients.
#pragma once

#include <optional>

#include "../objects/exact_space.hpp"
#include "form_family.hpp"

namespace vcell {

/// In the coordinates of the chart, in which a base point's normal is n / W.
struct Crossing {
    ExactVector center;
    Exact delta;         ///< radius of the cylinders, less the base's
    Exact divisor;       ///< of both; positive
    ExactVector normal;  ///< across both axes, of any length
};

/// Exact. None where the forms are not of two cylinders of one radius, or their axes do not cross in one
/// point. Pre: f and g are no circular forms.
std::optional<Crossing> equal_crossing(const FormFamily& family, FormId f, FormId g);

/// Does the axis of form h, of a cylinder, run through the crossing, across its normal?
bool runs_through(const FormFamily& family, FormId h, const Crossing& crossing);

}  // namespace vcell
