/// The bisector of two objects: the surface of points equally far from both [HE, Table 1].
///
/// Objects are seen from the cell's side. A base plane's points lie on the side of its normal, an object
/// plane's on the side of the base (of its centre, or of the point that describes its axis; if that lies on
/// the plane, on the side of the normal); two planes have both bisecting planes. A ball or cylinder is solid,
/// its distance negative inside, except where one of two objects contains the other: then the bisector lies
/// between their surfaces.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "../../core/curves/bspline.hpp"
#include "../objects/objects.hpp"
#include "polynomial3.hpp"

namespace vcell {

enum class BisectorKind {
    Plane,
    PairOfPlanes,
    Paraboloid,  ///< of revolution
    CircularCone,
    EllipticCone,
    ParabolicCylinder,
    HyperbolicCylinder,
    EllipticCylinder,
    CircularCylinder,
    HyperbolicParaboloid,
    Hyperboloid,  ///< of revolution, one of its two sheets
    Ellipsoid,    ///< of revolution
    Sphere,
    Quartic,
    Line,        ///< degenerate: a point on a plane or on a sphere sees the other along its normal
    Nowhere,     ///< a ball or cylinder wholly behind a base plane
    Everywhere,  ///< the objects are the same
};

/// "elliptic cone", "pair of planes", ...
std::string_view to_string(BisectorKind kind);

struct Bisector {
    BisectorKind kind = BisectorKind::Everywhere;
    /// Zero on the bisector, irreducible but for pairs of planes; zero and useless for the kinds from Line
    /// on. Exact about the input's doubles, but for the length of a plane's normal: where that is irrational
    /// it is rounded once, to the nearest double.
    Polynomial3 polynomial;
    /// Degrees of bisector_patch; {0, 0} where there is none.
    std::array<int, 2> patch_degree{0, 0};

    int degree() const { return polynomial.degree(); }
};

/// A vessel has one with a ball or a cylinder, which lies within or overlaps the wall, and without a
/// bisector_patch(); all else with vessels throws InputError (Unsupported). About a hollow cone's own axis it
/// is a circular cone, of whose polynomial another one is the other factor.
///
/// Decided exactly, but for |n| as above: parallel, crossing, concentric, containing are what the doubles
/// say.
Bisector bisector(const Object& base, const Object& a);
/// The bisector's kind alone, which takes no equation.
BisectorKind bisector_kind(const Object& base, const Object& a);

/// The piece of the bisector over a rectangle of the parameters (u, v):
///
///     kinds Plane, PairOfPlanes: lengths in the plane
///     plane - sphere         lengths in the plane from the foot of the centre
///     sphere - sphere        stereographic about the direction to the other centre: the unit disk is the
///                            half that faces it
///     any - cylinder         u: tangent of half the angle about the axis, 0 facing the other object (of axes
///                            that meet: along their common normal); v: length along the axis
///     skew, crossing axes    u: that angle of the base, v: of the other cylinder
///
/// `sheet` 1 is the second plane of a pair. None where the bisector is no surface, or where a weight is not
/// positive: the rectangle reaches beyond the surface's points at infinity. On quartics and hyperboloids the
/// formula continues to points of negative distance, of the other branch; small rectangles about (0, 0) stay
/// clear of them while the objects are disjoint.
/// Error: of the order of 2^-50 times the extent of control points and objects.
std::optional<RationalPatch> bisector_patch(const Object& base, const Object& a,
                                            const std::array<double, 2>& domain_u,
                                            const std::array<double, 2>& domain_v, int sheet = 0);

}  // namespace vcell
