/// The plane base: canonical position, height functions, bisector patches.
///
/// Canonical position: the base is z = 0, the cell lies on z > 0 and a base point is (x, y, 0). An
/// object is met at clearance t = C / (2 beta) (docs/references.md [HE], design of the heights):
///
///     sphere (c, rho)          C = |(x,y) - (cx,cy)|^2 + cz^2 - rho^2,   beta = cz + rho
///     plane n.p + D, side s    C = s (nx x + ny y + D),                  beta = (|n| - s nz) / 2
///     box side m.p <= k        C = k - m.(x, y, 0),                      beta = mz / 2
///
/// with beta <= 0: never met. Cylinders are CylinderForms (primitives/forms/cylinder_form.hpp), never met
/// where the axis is parallel to the base and the cylinder nowhere above it. All others are CircularForms
/// with w = 2 beta. |n| is told by two doubles (length_of()); where the difference |n| - s nz would cancel, C
/// and 2 beta are both multiplied by |n| + s nz, which leaves w = nx^2 + ny^2 and the height a relative error
/// of one rounding.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "../objects/scene.hpp"
#include "base_problem.hpp"

namespace vcell {

enum class AxisToBase : std::uint8_t { Parallel, Upright, Oblique };

/// A scene over a plane base, brought to canonical position and checked.
struct PlaneBaseProblem : BaseProblem {
    std::vector<Eigen::Vector2d> corners;  ///< corner i: start of side i, rounded
    /// Of corner i: the sides of the box that run through it in the scene as it is; three where the base
    /// plane runs through a corner of the box.
    std::vector<std::vector<Site>> corner_sites;
    /// How the axis of each of family.cylinders lies to the base, in the scene as it is: forms are exact
    /// about a base that may have turned a little.
    std::vector<AxisToBase> axes;
    /// Are the centres of two forms' balls on one normal of the base? Likewise.
    std::function<bool(FormId, FormId)> on_one_normal;

    /// Holds the region {x0, x1, y0, y1}, but for the rounding of its corners.
    std::array<double, 4> chart_box() const;
};

/// Throws InputError: Unsupported for bases that are no planes, EmptyBox when no region
/// of positive area lies both on the base and in the box (or the cell's side of it has no room),
/// TouchesBase (with object and place) for an object that cuts or touches the closed base region,
/// OutOfRange where a height's coefficients leave the double range. All of it by exact signs.
/// An object that meets the base outside the region only is legal.
/// Messages give places in lengths times `unit`.
/// Pre: validate(scene) has passed.
PlaneBaseProblem plane_base_problem(const Scene& scene, double unit = 1);

/// Area of the base region. Relative error at most 2^-49: the exact corners, rounded at the very end.
double region_area(const std::vector<RegionSide>& region);

}  // namespace vcell
