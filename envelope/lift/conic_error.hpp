/// How far conics, as written, may be from the true ones.
///
/// With t the distance from the base's centre or axis each of two sites is met where n.(p, t) = k, n a unit
/// vector of four dimensions (axial_conic.hpp; over a sphere base likewise): a hyperplane. Over a plane base
/// one of the sites, a cylinder, is taken for the base, and the base for a site (mixed_arc.cpp). The edge is
/// where both planes, an affine plane A together, meet the cone |p| = t (over a cylinder |(x, z)| = t).
///
/// *The bound.* Let X be a point of the curve, r the residuals of the planes, c that of the cone.
///
/// 1. With s the sine of the angle between the normals, A is within e = |r| / s of X: the least d with n.d =
/// -r
///    has the square (r1^2 - 2 (n1.n2) r1 r2 + r2^2) / s^2.
/// 2. On A the cone's equation has a gradient of length m: what is left of g = (u, -1), u the unit direction
/// of
///    p, without its part in the span of the normals. With k / t =: s (over a cylinder (k - n_y y) / t) g.n
///    is s - 2 n_t, linear in the homogeneous (1 : y : t), and m^2 is a concave function of these products:
///    along a span no less than in its control points. 2 - (g.n)^2 = 2 power + 4 n_t s - s^2 =: a. For the
///    plane with the larger |g.n|, its normal n turned so that this is positive, and n' the other one's, m^2
///    times the squared sine of their angle is
///        a (1 - 2 (n.n') (g.n') / (g.n + sqrt 2)) - (sqrt 2 n.n' - g.n')^2:
///    nothing of it cancels where the cone all but touches a plane.
/// 3. |p| - t is convex, its second derivative 1 / |p| at most: from a value phi on A it vanishes within 2
/// |phi| / m,
///    if 2 |phi| <= |p| m^2.
///
/// Residuals are bounded by their Bernstein coefficients, over those of the weights. A trim's point on its
/// patch is compared with the space curve in the same way, coefficient by coefficient; where rays do not
/// graze the bisector there is a cheaper bound, as parameters depend on directions and heights only: seen
/// along the rays a bisector takes an error times ray_gain() at most.
///
/// *Along rays.* On the ray of direction u a plane is met at t = (k - n_y y) / s, s = n.(u, 1), over a sphere
/// without y. Over a cylinder, where the direction turns to u' = u + d, n.d is no more than m = (a + |d| / 2)
/// |d| with a the length of what n has across u, and
///     t' - t = -(n_y (y' - y) + t n.d) / (s + n.d).
/// A trim's direction is the curve's but for what |p| and t differ there by, times the tangent h of half the
/// angle from its patch's middle: an error e of the curve is |y' - y| and t |d| / (1 + 2 h) together at most.
/// So |t' - t| <= e |(n_y, (1 + 2 h) (a + |d| / 2))| / (|s| - m). Of a needle, which all but lies along its
/// rays, a is small where s is.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "../../primitives/charts/chart.hpp"
#include "conic_span.hpp"
#include "cylinder_patch.hpp"
#include "radial_patch.hpp"

namespace vcell {

/// n.(p, t) = k. Both within 8 u, n a unit vector.
struct DistancePlane {
    Eigen::Vector4d normal;
    double k;
    /// The square of n's part in space less that of n_t, within 16 u of its own: next to nothing where a ball
    /// all but touches the base.
    double power;
};

/// The cone |(x, z)| = t is that of a cylinder base, and of whatever else is taken for the base.
inline constexpr Chart around_axis{BaseShape::Cylinder};

/// The distance of the spans' points from the conic of two planes. Where parts are not proved (the cone's
/// tip, planes that touch it) the arc goes on between those that are: four times their size. blur: what
/// rounding has moved points and planes to each other, or the cone, before.
double conic_distance(std::span<const ConicSpan> spans, const std::array<DistancePlane, 2>& planes,
                      Chart chart, double blur = 0);

/// By which factor an error of the curve, `off` at most, may grow on the bisector of this plane, all along
/// the spans; infinite where they, or what is so far from them, reach its points at infinity.
double ray_gain(std::span<const ConicSpan> spans, const DistancePlane& plane, Chart chart, double off);

/// |S(c) - C| for a span C of the curve and its trim c on a patch S of total degree two (over a sphere base:
/// all but AboutObject), of degree two then, or on one AboutBase, of degree three. Infinite where that is not
/// proved.
double trim_distance(const RadialPatch& patch, const ConicSpan& span, const ConicTrim& trim);
/// Likewise on a cylinder's patch over a plane base. Pre: the degree is three.
double trim_distance(const CylinderFrame& patch, const ConicSpan& span, const ConicTrim& trim);

}  // namespace vcell
