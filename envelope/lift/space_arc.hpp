/// What the fit of an edge (space_spline.hpp) is told and what it yields: its sites, ends and patches, and
/// the spans that follow it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "../../primitives/forms/twin_quadric.hpp"
#include "../../primitives/objects/objects.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "patch_coordinate.hpp"
#include "radial_patch.hpp"

namespace vcell {

/// Which part of a face a boundary runs in that may run along a seam: the one with the point this far inside
/// the face, in what is counted across the seam.
constexpr double seam_inwards = 0x1p-32;

/// A patch and the range of a function across its seams for which it is used: a face that wraps around needs
/// several.
struct SpacePart {
    PatchCoordinates patch;
    PatchCoordinate across{};
    std::array<double, 2> range{-std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity()};
    const RadialPatch* surface = nullptr;  ///< with these coordinates, of polynomials (P, w)(u, v)
    /// Of one of two parts between the same seams: a point is in it if its product with this is positive.
    Vec3 side = Vec3::Zero();
    std::uint32_t other = 0;  ///< the other one, of the first of both, before which no part is such a one

    /// Pre: the point lies between its seams.
    bool holds(const Vec3& p) const { return !(side.dot(p) < 0); }
};

/// What lies on one side of an edge, canonical.
struct SpaceSite {
    Object object;
    bool is_wall = false;  ///< a Plane with outward normal that bounds the cell: a side of the box, an end
    std::vector<SpacePart> parts{};  ///< none: no trim on this side
    /// Where the first parts begin, ascending: angles, if they are sectors once around an axis and `across`
    /// is the tangent of half the angle from a sector's middle; lengths, if they are strips and `across` is
    /// one; of others none. After these come the others of two.
    std::vector<double> starts{};
    std::optional<double> power = std::nullopt;  ///< of a ball around a ball (ball_power())
};

struct SpaceEnd {
    Vec3 point;
    double error;  ///< bound on its distance from the true vertex
};

/// An edge. The arc of a rim has no pieces, and the end on its right: the Plane through (0, y, 0) across the
/// y axis.
struct SpaceArc {
    std::array<SpaceSite, 2> sites;      ///< left, right
    std::optional<SpaceEnd> start, end;  ///< none: closed
    std::span<const MinimizationDiagram::ArcPiece> pieces;
    double turn = 0;           ///< of a rim's arc; 0: its ends' points tell
    bool sites_cross = false;  ///< both are cylinders, of one radius, and their axes cross
    std::optional<SpaceQuadric> twins = std::nullopt;  ///< the right form less the left one, if they are
    bool is_turned = false;  ///< the site on the left has the face on the right, and spans its trim there
};

/// A Bezier span of degree 5, polynomial: space curve and trims in one parameter.
struct SpaceSpan {
    /// Point k of (x, y, z, t, u_left, v_left, u_right, v_right) is column k; zeros where there is no trim.
    Eigen::Matrix<double, 8, 6> points = Eigen::Matrix<double, 8, 6>::Zero();
    /// The part on each side that holds the span: where the arc leaves a part, a span ends.
    std::array<std::uint32_t, 2> part{};
};

}  // namespace vcell
