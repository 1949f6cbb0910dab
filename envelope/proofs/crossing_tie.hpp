/// The node over tubes of one radius that cross.
///
/// Where the axes cross, the points of the line across them are as far from all tubes, with the same gradient
/// (primitives/forms/crossing.hpp). So where a point of the line is as near to the base, too, all forms tie
/// and have equal gradients. Such a point lies between two points of the line on different sides of the
/// tubes' bisector. If the line runs along a normal of the base, all forms are one along it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/forms/form_family.hpp"

namespace vcell {

/// Is it proved that all these forms are of tubes that cross so, and tie with equal gradients in a point of
/// the chart that is `inside`? Exact about crossings, by intervals about places. near, width: where that
/// point is expected, and how wide its surroundings may be that are inside. Pre: at least two forms, none of
/// them circular.
bool is_tie_over_crossing(const FormFamily& family, std::span<const FormId> forms,
                          const std::function<bool(const Interval& x, const Interval& y)>& inside,
                          const Eigen::Vector2d& near, double width);

}  // namespace vcell
