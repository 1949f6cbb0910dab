/// The trisector of three objects: the curve of points equally far from all [HE, Table 2 and Lemmas 1-4].
///
/// With the distance r as a fourth coordinate each plane is a linear equation and each sphere or cylinder a
/// quadric |p - foot|^2 = (r + rho)^2. Two spheres, or cylinders with parallel axes, differ by a linear
/// equation. So
///
///     three linear equations                  a line;
///     two linear equations and a quadric      a conic, or lines;
///     one linear equation and two quadrics    a curve of degree 4, plane if the equation is free of r;
///     three quadrics                          a curve of degree 8.
///
/// The last two fall into conics and lines where a pencil of the quadrics holds a pair of planes: crossing
/// axes of equal radius, centres on axes, coaxial and tangent positions. That is decided exactly, for planes
/// with rational coefficients; where they are irrational the whole curve stays a spline.
///
/// Objects are seen as by bisector(); an object plane over a base plane has two sides, and both count.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../objects/objects.hpp"

namespace vcell {

enum class TrisectorKind { Line, Circle, Ellipse, Parabola, Hyperbola, Spline };

/// "line", ..., "spline", as in cell files.
std::string_view to_string(TrisectorKind kind);

/// One line, conic or unsplit curve. All numbers are exact ones rounded once.
struct TrisectorComponent {
    TrisectorKind kind = TrisectorKind::Spline;
    int degree = 1;  ///< algebraic, counting virtual branches
    /// Lines: a point and the unit direction.
    Vec3 point = Vec3::Zero(), direction = Vec3::Zero();
    /// Conics: unit n and d with n . p + d = 0 on the plane, and a quadric M that meets the plane in the
    /// conic, (p, 1)^T M (p, 1) = 0.
    Eigen::Vector4d plane = Eigen::Vector4d::Zero();
    Eigen::Matrix4d quadric = Eigen::Matrix4d::Zero();
    /// Lines and conics: c with r = c . (p, 1); none where the distance is no linear function (equal radii).
    std::optional<Eigen::Vector4d> clearance;
};

struct Trisector {
    std::vector<TrisectorComponent> components;
    /// A spline component is known to fall into plane curves, but their planes are irrational.
    bool splits_irrationally = false;

    int degree() const {
        int sum = 0;
        for (const TrisectorComponent& c : components) sum += c.degree;
        return sum;
    }
};

/// The curves that contain every point equally far from the three; components without a real point at an
/// admissible distance are left out (exactly, for lines and conics). Isolated points are no components. Exact
/// about the doubles, as bisector(): |n| of planes is rounded once where it is irrational. Throws InputError
/// (Unsupported) for vessels. Pre: no two of the objects are the same.
Trisector trisector(const Object& base, const Object& a, const Object& b);

/// The same of three solids, seen from outside all of them: a plane is the half space behind it, whose
/// distance counts on the side that its normal points to alone, and distances are not negative.
Trisector trisector_of_solids(const Object& a, const Object& b, const Object& c);

/// The arc of a line or conic between two of its points, as a segment or rational quadratic Bezier curve on
/// [0, 1]: of an ellipse the shorter arc. None for splines, for points of different branches, and where the
/// tangents at both ends are parallel.
/// Pre: the points lie on the component, up to rounding.
std::optional<RationalCurve3> trisector_arc(const TrisectorComponent& component, const Vec3& from,
                                            const Vec3& to);

}  // namespace vcell
