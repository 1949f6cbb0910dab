/// Splines for the edges of cells that are no conics, and with them the trims on both sides: the fit of
/// primitives/fit/spline_fit.hpp, whose header has the proof, led by the pieces of the minimization diagram.
/// The patches' coordinates are quotients of linear functions of X (PatchCoordinate); a trim has their values
/// at the six places where its span interpolates (space_trims.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "../../primitives/charts/chart.hpp"
#include "../../primitives/fit/fit_error.hpp"
#include "space_arc.hpp"

namespace vcell {

/// The point in which three sites are met, from one within `near.error` of it, and a bound of the distance
/// that is left: at the level of rounding, whatever the chart made of the scene's size. None where this
/// bound is no smaller, or not proved (nearly dependent gradients).
std::optional<SpaceEnd> settle_point(const BaseChart& chart, const std::array<SpaceSite, 3>& sites,
                                     const SpaceEnd& near);

/// Appends the spans of an arc. tolerance: length, for both errors. The result exceeds it only where rounding
/// blurs the arc and the diagram's pieces are wider, where the ends are not known as well (four times their
/// error bounds it then), where a divisor of a patch's coordinate is not positive, or when `effort` is spent,
/// and says so.
SpaceFitError fit_space_spline(const BaseChart& chart, const SpaceArc& arc, double tolerance,
                               std::vector<SpaceSpan>& spans, FitEffort& effort);

}  // namespace vcell
