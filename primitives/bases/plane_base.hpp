/// The plane base: canonical position, height functions, bisector patches.
///
/// Canonical position: the base is z = 0, the cell lies on z > 0 and a base point is (x, y, 0). An
/// object is met at clearance t = C / (2 beta) (docs/references.md [HE], design of the heights):
///
///     sphere (c, rho)          C = |(x,y) - (cx,cy)|^2 + cz^2 - rho^2,   beta = cz + rho
///     plane n.p + D, side s    C = s (nx x + ny y + D),                  beta = (|n| - s nz) / 2
///     box side m.p <= k        C = k - m.(x, y, 0),                      beta = mz / 2
///     hollow sphere (c, R)     C = R^2 - cz^2 - |(x,y) - (cx,cy)|^2,     beta = R - cz
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
#include <optional>
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
    /// How the axis of each of family.cylinders lies to the base, of a cone's Parallel if a line of the wall
    /// is: in the scene as it is; forms are exact about a base that may have turned a little.
    std::vector<AxisToBase> axes;
    /// Are the centres of two forms' balls on one normal of the base? Likewise.
    std::function<bool(FormId, FormId)> on_one_normal;
    /// With a floor: the part of the base in the box. `region` is more of complete_plane_base_problem().
    std::vector<RegionSide> region_in_box;
    /// Rays begin over all of these, the base itself first, then sides of the box:
    /// complete_plane_base_problem() has a floor, and the other one where a vessel's wall cuts the region.
    /// They are forms, the last ones but for cylinders', but do not compete. Base points beyond a wall have
    /// heights below 0, so that none of the cell is over them, and its rim is where the least height is that
    /// of the base.
    std::vector<FormId> floor;
    bool has_curved_rim = false;  ///< does a vessel's wall cut the region?

    /// Holds the region {x0, x1, y0, y1}, but for the rounding of its corners.
    std::array<double, 4> chart_box() const;
    /// Is the form's face lifted? The floor's are with the other part's, too, whose trims they have.
    bool lifts(FormId f, bool is_below_floor) const {
        return shows(f, is_below_floor) || (f >= floor.front() && f <= floor.back());
    }
    /// Is there a floor, and does this diagram's part of the cell's boundary have the faces of that form?
    /// Those above have the floor's faces where all rays have been met, or none has come in.
    bool shows(FormId f, bool is_below_floor) const {
        if (floor.empty()) return true;
        return is_below_floor ? f > floor.front() && f <= floor.back()
                              : f < floor.front() || f > floor.back();
    }
};

/// Throws InputError: Unsupported for bases that are no planes, EmptyBox when no region of positive area
/// lies both on the base and in the box (or the cell's side of it has no room), or none of it within the wall
/// of a vessel,
/// TouchesBase (with object and place) for an object that cuts or touches the closed base region,
/// OutOfRange where a height's coefficients leave the double range. All of it by exact signs.
/// An object that meets the base outside the region only is legal.
/// Messages give places in lengths times `unit`.
/// Pre: validate(scene) has passed.
PlaneBaseProblem plane_base_problem(const Scene& scene, double unit = 1);

/// The same for all rays that come into the box, from base points outside it, too.
///
/// A ray runs along the base's normal, and in the box from e, the greatest of 0 and of the clearances at
/// which it comes in through sides, to the least at which it leaves through one or meets an object:
/// through a side m.p <= k with m.n < 0 it comes in at t = (m.f - k) / |m.n|, a linear form as those of sides
/// with m.n > 0, through which it leaves. A side along the normal bounds the region. So all of the box that
/// is nearest to the base lies between the upper envelope of `floor` and the lower envelope of the other
/// forms, where the one is below the other (envelope/lift/complete_lift.hpp). The region holds all base
/// points from which rays come into the box, and a margin around them; objects must stay clear of all of
/// that.
///
/// None: the box holds all base points from which rays come into it.
/// Throws as plane_base_problem() does, and InputError (Unsupported) where a plane lies so that it bounds
/// what is nearest to the base along all of a side of the box through which rays come in.
std::optional<PlaneBaseProblem> complete_plane_base_problem(const Scene& scene, double unit = 1);

/// Can complete_plane_base_problem() tell? Not of other bases.
bool may_be_completed(const Scene& scene);

/// Do a base plane's rays come into the box through this side (Site::box_side)? False over other bases.
bool lets_rays_in(const Scene& scene, std::uint32_t side);

/// Area of the base region. Relative error at most 2^-49: the exact corners, rounded at the very end.
double region_area(const std::vector<RegionSide>& region);

}  // namespace vcell
