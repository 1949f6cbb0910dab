/// The equations of a vertex: four planes, spheres and cylinders at one distance.
#pragma once

#include <array>
#include <variant>

#include "../../core/solver/roots/solver.hpp"

namespace vcell {

/// The half space's plane n.p + D = 0; its clearance counts on the side where n.p + D > 0. n need not
/// be unit.
struct PlaneSite {
    std::array<double, 3> normal;
    double offset;
};
struct SphereSite {
    std::array<double, 3> center;
    double radius;
};
/// All points at distance `radius` from the line point + s direction; the direction need not be unit.
struct CylinderSite {
    std::array<double, 3> point;
    std::array<double, 3> direction;
    double radius;
};
using VertexSite = std::variant<PlaneSite, SphereSite, CylinderSite>;

/// The points (x, y, z) with the same distance r from four objects, in the unknowns x, y, z, r:
///
///     plane      n.p + D = |n| r
///     sphere     |p - c|^2 = (r + rho)^2
///     cylinder   |d|^2 |p - c|^2 - (d.(p - c))^2 = |d|^2 (r + rho)^2
///
/// The squared equations also hold for the distance -(r + rho) - rho; r + rho >= 0 excludes that, so
/// the box to search has r >= least_clearance().
struct VertexSystem {
    std::array<VertexSite, 4> sites;

    template <class T>
    QuadraticForms<4, T> forms() const;
    /// max of -rho over spheres and cylinders; -infinity for four planes.
    double least_clearance() const;
};

extern template QuadraticForms<4, Interval> VertexSystem::forms<Interval>() const;
extern template QuadraticForms<4, Wide> VertexSystem::forms<Wide>() const;
extern template Solutions<4> solve(const VertexSystem&, const IntervalBox<4>&, const SolverOptions&);

}  // namespace vcell
