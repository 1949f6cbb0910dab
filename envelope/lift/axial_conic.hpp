/// The conics over a cylinder base: edges between planes, sides of the box, ends and cylinders along the
/// base.
///
/// Where one of these is met, p and the distance t from the base's axis obey a linear equation (t Q = W in
/// C Q = 2 B, C linear in y):
///
///     b.p + b0 t = k,     b = (b_x, -c1 / 2, b_z),     k = c0 / 2
///
/// with the coefficients of core/radial_form.hpp. Two of them and x^2 + z^2 = t^2 make a conic. Eliminating y
/// leaves m.(x, z, t) = c: over every direction of the base's normal there is one point of the conic, t = c /
/// m.(w, 1). It has two, one or no points at infinity as m_x^2 + m_z^2 - m_t^2 is positive, zero or negative;
/// and c = 0 says that it is a pair of lines through a point of the axis.
///
/// Over an arc of directions w0 ... w1, half of it a, the middle control point in (x, z, t) is that of the
/// circle, sqrt(t0 t1) times (the middle direction, cos a): the equations have its y and weight.
#pragma once

#include <optional>

#include "../../primitives/bases/radial_base.hpp"
#include "../cell.hpp"
#include "conic_error.hpp"
#include "conic_span.hpp"
#include "radial_patch.hpp"

namespace vcell {

/// The equation above, in coordinates of the chart. Exact, but for the length b0 = |b| of a plane's normal.
struct AxialEquation {
    std::array<Exact, 3> b;
    Exact b0, k;
    bool has_plane = false;  ///< an object
};

/// None for balls, and cylinders that are not along the base. Pre: over a cylinder.
std::optional<AxialEquation> axial_equation(const RadialForm& form);
/// An end.
AxialEquation axial_equation(double y);

/// Line, or a conic. Exact, with b0^2 = b.b of planes as it is and not as it is rounded: what a plane along
/// the base's axis leaves on an end is a parabola, and two planes meet in one where either is along the axis.
CurveKind kind_of(const AxialEquation& f, const AxialEquation& g);
/// Do both meet the axis in one point, or within some 2^-48 of `size` (of y) as where a tilted base's axis is
/// rounded? Then the conic is a pair of lines through it, or as near to one as its points are known.
bool is_pair_of_lines(const AxialEquation& f, const AxialEquation& g, double size);

class AxialConic {
public:
    /// Pre: it is no pair of lines. The nearer to one it is, the less do the equations tell the parameters of
    /// its points; but as solved for they hold to rounding, and so the points are on it.
    AxialConic(const RadialBaseProblem& problem, const AxialEquation& f, const AxialEquation& g);

    /// (p, t) in the direction of a unit normal, canonical.
    Eigen::Vector4d at(const Vec3& normal) const;
    /// The equations, over unit normals.
    std::array<DistancePlane, 2> planes() const { return planes(equations_); }
    /// That of f, and where g's is nearly the same what tells g from it, which has all its digits.
    std::array<DistancePlane, 2> planes_apart() const { return planes(apart_); }
    /// The arc between two of its points, less than half a turn of the normal.
    ConicSpan between(const Eigen::Vector4d& from, const Eigen::Vector4d& to) const;

private:
    struct Equation {
        Vec3 b;  // canonical
        double b0, k;
    };
    using Equations = std::array<Equation, 2>;
    static std::array<DistancePlane, 2> planes(const Equations& equations);

    Equations equations_, apart_;
};

}  // namespace vcell
