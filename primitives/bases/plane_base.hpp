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

#include "../forms/form_family.hpp"
#include "../objects/scene.hpp"
#include "../objects/site.hpp"

namespace vcell {

/// A rigid motion between world and canonical coordinates: canonical = R (world - origin), rounded. Forms are
/// those of an exact motion: for axis-parallel normals R is a signed permutation and the origin the base's
/// point on that axis, or near a box that is far from the scene's origin; in general R is a rotation with
/// rational entries (exact_motion.hpp) and the origin a point of the base near the box. Objects are to each
/// other exactly what they are in the scene. What is rounded, and counted in PlaneBaseProblem::moved: the
/// sides of the box, to doubles in canonical coordinates, and unless the normal's length is a double the base
/// itself, which turns by a few 2^-53 (planes parallel to it turn with it).
struct BaseFrame {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 origin = Vec3::Zero();

    bool is_axis_parallel() const { return (rotation.array() == 0).count() == 6; }
    Vec3 to_canonical(const Vec3& world) const { return rotation * (world - origin); }
    Vec3 to_world(const Vec3& canonical) const { return rotation.transpose() * canonical + origin; }
};

/// A side of the base region: which side of the box cuts the base plane there.
struct RegionSide {
    double a, b, c;  ///< a x + b y + c >= 0 inside, canonical coordinates
    Site site;
};

enum class AxisToBase : std::uint8_t { Parallel, Upright, Oblique };

/// A scene over a plane base, brought to canonical position and checked.
struct PlaneBaseProblem {
    BaseFrame frame;
    BaseChart chart;
    std::vector<RegionSide> region;        ///< convex polygon, counter-clockwise
    std::vector<Eigen::Vector2d> corners;  ///< corner i: start of side i, rounded
    /// Of corner i: the sides of the box that run through it in the scene as it is; three where the base
    /// plane runs through a corner of the box.
    std::vector<std::vector<Site>> corner_sites;
    FormFamily family;
    /// A bound on the distance that anything of the scene within the box has moved, in its unit: the base and
    /// the sides of the box with the motion, planes by the rounding of |n|, which scales distances from them.
    double moved = 0;
    /// A bound on how far planes have moved against each other, balls and tubes: by the rounding of |n|
    /// alone, where no plane turns with the base.
    double moved_apart = 0;
    double unit = 1;  ///< of the scene's lengths, for messages
    /// How the axis of each of family.cylinders lies to the base, in the scene as it is: forms are exact
    /// about a base that may have turned a little.
    std::vector<AxisToBase> axes;
    /// Are the centres of two forms' balls on one normal of the base? Likewise.
    std::function<bool(FormId, FormId)> on_one_normal;
    /// The sites of each form, ascending: several when objects coincide as seen from the base
    /// (duplicates, a plane whose bisector is the box side). Objects hidden in cylinders, and cylinders
    /// hidden beyond planes or sides of the box, have none: at best they tie with what hides them.
    IdVector<FormId, std::vector<Site>> sites;
    std::vector<std::string> warnings;  ///< merged duplicates; objects behind the base, or hidden

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
