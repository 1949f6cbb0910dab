/// The bisector of a plane base and a cylinder: its height in double, and a frame in which it is a polynomial
/// patch.
///
/// Let the axis run through c with unit direction d, d_z >= 0, and write d for (d_x, d_y) too. With
///
///     V(p) = d_z (p - (c_x, c_y)) + (rho + c_z) d,    s = |V|
///
/// the root of primitives/forms/cylinder_form.hpp is s, and the height is
///
///     f(p) = (s - d.V) / d_z^2 - rho,   grad f = (V / s - d) / d_z,   Hess f = t t^T / s
///
/// with the unit vector t across V: a multiple of the distance from a point A plus a linear function. A,
/// where V = 0, is the projection of the axis's point at height -rho: that point is the cone's apex, and A a
/// focus of the ellipse that the cylinder cuts from the base. The chart's rays from A lift to the cone's
/// rulings.
///
/// *One patch is enough.* The base region is convex and does not meet that ellipse, so from A, inside the
/// ellipse, it is seen under less than a half turn. Half angles of directions about A, counted from a
/// direction into the region, never meet their pole. (The foot point on the cylinder may well pass its
/// highest line, behind a leaning cylinder; with the half angle about the axis, counted from the lowest line,
/// that would be the pole.)
///
/// *Hollow cylinders.* The bisector of one of radius R, reflected in the base, is that of the solid cylinder
/// of radius R about the reflected axis, continued below the base: within the trace on the base that one's
/// height is negative. So c, d, rho, s and V are those of the reflected cylinder, and heights are the
/// negative ones. A may lie in the region, and faces around it have several patches (cylinder_sectors.hpp).
///
/// *Hollow cones.* Let c be the apex, S the sine of half the angle, K its cosine and rho = 0. Of the cone
/// that is reflected in the base, S being below 0 then, with lambda = d_z - S in place of d_z,
///
///     f(p) = (K s - d.V) / lambda^2 - H,   grad f = (K V / s - d) / lambda,   Hess f = K t t^T / s,
///
/// and the tip is H = rho + S c_z / lambda below the base. For tubes S = 0 and K = 1. Where lambda would be
/// below 0, it, S and d are turned together.
#pragma once

#include <Eigen/Core>
#include <array>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/forms/cylinder_form.hpp"
#include "patch_coordinate.hpp"

namespace vcell {

/// The height of a cylinder's bisector, plain double arithmetic.
class CylinderHeight {
public:
    struct Jet {
        double value;
        Eigen::Vector2d gradient;
        Eigen::Vector2d v;  ///< V
        double s;           ///< |V|: the root, and the reciprocal of the curvature across V
    };

    CylinderHeight() = default;
    /// `near`: the axis's point is moved along the axis to where it is nearest to (near, 0), so that
    /// coordinates are as small as they can be.
    CylinderHeight(const CylinderForm& form, const Eigen::Vector2d& near);

    Jet operator()(const Eigen::Vector2d& p) const;
    /// 1; -1 of a hollow cylinder's: point(), axis() and rho() are those of the reflected one.
    double side() const { return side_; }
    /// A. Pre, here and below: no line of the wall is parallel to the base.
    Eigen::Vector2d focus() const { return c_.head<2>() - (c_.z() + rho_) / steep_ * d_.head<2>(); }
    /// H.
    double depth() const { return rho_ + sine_ * c_.z() / steep_; }

    /// An upper bound of |Hess f| within `radius` of a point where s is known.
    double curvature_bound(double s, double radius) const;
    /// An upper bound of |grad f| within `radius` of the point of a jet.
    double slope_bound(const Jet& at, double radius) const;

    double rho() const { return rho_; }
    const Eigen::Vector3d& point() const { return c_; }
    const Eigen::Vector3d& axis() const { return d_; }
    double sine() const { return sine_; }      ///< S
    double cosine() const { return cosine_; }  ///< K
    double steep() const { return steep_; }    ///< lambda
    /// The lengths whose roundings make up the error of point(), times a few units of 2^-53.
    double reach() const { return reach_; }

private:
    Eigen::Vector3d c_, d_;
    double rho_ = 0, reach_ = 0, side_ = 1, sine_ = 0, cosine_ = 1, steep_ = 0;
};

/// Coordinates (u, v) about a point p0 of the chart in which the chart and the height are polynomials, for
/// cones and for their limit, the parabolic cylinder, alike. With e along V(p0), e' to its left, and eps =
/// lambda / |V(p0)|, the reciprocal of the distance of A,
///
///     p - p0 = (u - mu eps v^2 / 4) e + mu v e',    mu = 1 + eps u,
///     f      = f0 + rise u + mu (z1 v + z2 v^2),    rise = eps (f0 + H),
///                                                   z1 = grad f(p0).e',  z2 = (K + d.e) / (4 s(p0)).
///
/// (The ray at the half angle atan(eps v / 2) about A, and on it the distance R = mu (1 + eps^2 v^2 / 4) /
/// eps, on which f + H depends linearly.) Lengths near p0; (u, v) is oriented like the chart. For a wall
/// with a line parallel to the base eps = 0: (u, v) is the chart turned. What is hollow has the f of what is
/// reflected.
class CylinderFrame {
public:
    CylinderFrame() = default;
    /// Pre: p0 is not A.
    CylinderFrame(const CylinderForm& form, const Eigen::Vector2d& p0);

    const CylinderHeight& height() const { return height_; }
    const Eigen::Vector2d& origin() const { return origin_; }
    const Eigen::Vector2d& direction() const { return e_; }  ///< e
    double eps() const { return eps_; }
    double f0() const { return f0_; }
    double fall() const { return fall_; }  ///< eps H
    double rise() const { return eps_ * f0_ + fall_; }
    double z1() const { return z1_; }
    double z2() const { return z2_; }
    double mu(double u) const { return 1 + eps_ * u; }
    /// A chart vector's components along e and e'.
    Eigen::Vector2d turned(const Eigen::Vector2d& q) const {
        return {e_.dot(q), e_.x() * q.y() - e_.y() * q.x()};
    }
    Eigen::Vector2d turned_back(const Eigen::Vector2d& q) const {
        return q.x() * e_ + q.y() * Eigen::Vector2d(-e_.y(), e_.x());
    }

    /// (u, v) of a chart point in the region.
    Eigen::Vector2d parameters(const Eigen::Vector2d& p) const;

    /// (u, v) of the patch's points as functions of them: quotients of linear functions of (x, y, z).
    PatchCoordinates coordinates() const;

    /// The bisector over a rectangle of (u, v): degree (1, 2), polynomial.
    RationalPatch patch(const std::array<double, 2>& u, const std::array<double, 2>& v,
                        const BaseFrame& frame) const;

private:
    CylinderHeight height_;
    Eigen::Vector2d origin_, e_;
    double eps_ = 0, f0_ = 0, fall_ = 0, z1_ = 0, z2_ = 0;
};

}  // namespace vcell
