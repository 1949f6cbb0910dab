/// The equations of a vertex: four planes, spheres and cylinders at one distance, or planes that bound the
/// cell in the place of some of them.
#pragma once

#include <array>
#include <variant>

#include "../../core/solver/systems/quadratic_system.hpp"
#include "../objects/objects.hpp"

namespace vcell {

/// The half space's plane n.(p - point) + D = 0; its clearance counts on the side where this is positive. n
/// need not be unit.
struct PlaneSite {
    std::array<double, 3> normal;
    double offset = 0;
    std::array<double, 3> point{};
};
struct SphereSite {
    std::array<double, 3> center;
    double radius;  ///< of a hollow sphere negative: r <= -radius is what its distance asks for
};
/// All points at distance `radius` from the line point + s direction; the direction need not be unit.
struct CylinderSite {
    std::array<double, 3> point;
    std::array<double, 3> direction;
    double radius;
};
/// The inside of a cone, `radius` / `slant` being the sine of half its angle; the direction need not be unit.
struct ConeSite {
    std::array<double, 3> apex;
    std::array<double, 3> direction;
    double radius, slant;
};
/// A side of the box: p_axis = bound, at any distance; of axis 3 all that is at one distance, r = bound.
struct BoxSideSite {
    int axis;
    double bound;
};
/// The rim of a base plane's region on a side of the box: the foot of p on the plane has the coordinate
/// `bound`.
struct RimSite {
    PlaneSite base;
    BoxSideSite side;
};
/// The plane across a tube in which the tube's circle touches a side of the box, from below or from above.
struct EndSite {
    CylinderSite tube;
    BoxSideSite side;
    bool from_below;
};
using VertexSite = std::variant<PlaneSite, SphereSite, CylinderSite, BoxSideSite, RimSite, EndSite, ConeSite>;

/// An object as such a site. The clearance of a plane counts on the side on which `inside` is.
PlaneSite vertex_site(const Plane& plane, const Vec3& inside);
SphereSite vertex_site(const Sphere& sphere, const Vec3& inside);
CylinderSite vertex_site(const Cylinder& tube, const Vec3& inside);
SphereSite vertex_site(const HollowSphere& vessel, const Vec3& inside);
CylinderSite vertex_site(const HollowCylinder& vessel, const Vec3& inside);
ConeSite vertex_site(const HollowCone& vessel, const Vec3& inside);
VertexSite vertex_site(const Object& object, const Vec3& inside);

/// The points (x, y, z) with the same distance r from four objects, in the unknowns x, y, z, r:
///
///     plane      n.(p - point) + D = |n| r
///     sphere     |p - c|^2 = (r + rho)^2
///     cylinder   |d|^2 |p - c|^2 - (d.(p - c))^2 = |d|^2 (r + rho)^2
///     cone       (cos |p - c|)^2 = (d.(p - c) / |d|)^2 - 2 sin r d.(p - c) / |d| + r^2, times (|d| slant)^2
///     rim        |n| p_axis - n_axis r = |n| bound, if r is the distance from the base: the foot is p - r n
///     / |n| end        d.(p - c) = s |d|^2 with c_axis + s d_axis +- rho |d - d_axis e_axis| / |d| = bound
///
/// The squared equations also hold for the distance -(r + rho) - rho; r + rho >= 0 excludes that, so
/// the box to search has r >= least_clearance(). That of a cone also holds beyond its wall's other half.
struct VertexSystem {
    std::array<VertexSite, 4> sites;

    template <class T>
    QuadraticForms<4, T> forms() const;
    /// max of -rho over spheres and cylinders that are not hollow; -infinity where there are none.
    double least_clearance() const;
};

extern template QuadraticForms<4, Interval> VertexSystem::forms<Interval>() const;
extern template QuadraticForms<4, Wide> VertexSystem::forms<Wide>() const;

}  // namespace vcell
