/// Rational B-spline curves and rational Bezier patches: the forms in which geometry leaves vcell.
#pragma once

#include <Eigen/Core>
#include <array>

#include "../small_vector.hpp"

namespace vcell {

/// Room for two quadratic spans inside.
using Knots = SmallVector<double, 8>;

/// A rational B-spline curve in R^Dim over a full, clamped knot vector.
/// Control point i is points[i] = (x_1, ..., x_Dim, w): Euclidean coordinates (w already divided out)
/// and the weight w > 0. knots.size() == points.size() + degree + 1.
template <int Dim>
struct RationalCurve {
    using Point = Eigen::Matrix<double, Dim, 1>;
    using ControlPoint = Eigen::Matrix<double, Dim + 1, 1>;

    int degree = 1;
    Knots knots;
    SmallVector<ControlPoint, 5> points;

    double domain_begin() const { return knots.front(); }
    double domain_end() const { return knots.back(); }
    /// The curve's point at t; t is clamped to the domain. De Boor on homogeneous points.
    Point evaluate(double t) const;
    /// Position and first derivative with respect to t.
    std::array<Point, 2> evaluate_with_derivative(double t) const;
};

using RationalCurve2 = RationalCurve<2>;
using RationalCurve3 = RationalCurve<3>;

extern template struct RationalCurve<2>;
extern template struct RationalCurve<3>;

/// A rational tensor-product Bezier patch on domain [u0,u1] x [v0,v1].
/// Control point (i, j), u-degree index i, v-degree index j, is points[i * (degree_v + 1) + j]
/// = (x, y, z, w), Euclidean coordinates and weight w > 0.
struct RationalPatch {
    int degree_u = 1;
    int degree_v = 1;
    std::array<double, 2> domain_u{0, 1};
    std::array<double, 2> domain_v{0, 1};
    SmallVector<Eigen::Vector4d, 9> points;

    const Eigen::Vector4d& point(int i, int j) const { return points[i * (degree_v + 1) + j]; }
    /// The surface point at (u, v); valid outside the domain too (the polynomial extension).
    Eigen::Vector3d evaluate(double u, double v) const;
    /// Partial derivatives (d/du, d/dv) at (u, v).
    std::array<Eigen::Vector3d, 2> partials(double u, double v) const;
};

}  // namespace vcell
