/// Measures over sphere and cylinder bases as integrals along the edges.
///
/// Over a face seen along the base's normals, with t the distance from the base's centre or axis, volume (the
/// base's body included) and area are integrals over solid angles, or over angle and height on a cylinder:
///
///     sphere    dV = t^3 / 3 d omega,         cylinder    dV = t^2 / 2 d theta dy
///
/// Each has an antiderivative in one coordinate, which makes it an integral along the boundary (Green,
/// Stokes). With delta = rho - R0, p the curve, u its direction from the centre or w from the axis:
///
/// *Spheres, planes, sides of the box over a sphere.* The bisector is a surface of revolution about the unit
/// vector b through the centre. With d1 its least distance from the base's centre, d2 = d1 + delta that from
/// the object's, c = d1 + d2 and z = b.u the integrals over z from the axis on are, since t (delta + c z) = 2
/// d1 d2,
///
///     V = closed integral of  c (t + d1) / (12 (t + d2))  b.(p x dp),
///     S = closed integral of  c / (2 sqrt(d1 d2) (t + d2)) M(t)  b.(p x dp),
///
/// M(t) the mean of sqrt(x (x + delta)) over d1 <= x <= t. Flat bisectors have delta = 0: both are multiples
/// of the shoelace formula. Planes are the limit of d2 to infinity.
///
/// *Hollow spheres over a sphere.* The bisector is an ellipsoid: with delta the sum of R and R0, the same
/// with b towards the wall's nearest point, t (delta + c z) = 2 d1 d2, d2 - t in the place of t + d2, and
/// M(t) the mean of sqrt(x (delta - x)). These integrals are singular at the far pole, t = d2, which all of
/// the ellipsoid has; what dV and dS are more than their means times d omega has others that are not. With
/// omega the face's solid angle (solid_angle.hpp), V0 = d1 d2 delta / 6 and S0 all of the area by 4 pi,
///
///     V = V0 omega - closed integral of  c (t + delta) / (12 t)  b.(p x dp),
///     S = S0 omega + closed integral of  (m1 - m2) / (2 t^2)  b.(p x dp),
///
/// m1 and m2 the means of dS / d omega over the z that are greater, and less. They are taken of faces whose
/// edges come near the far pole: of others what they begin with is larger than the face.
///
/// *The cap over a sphere*, and a hollow sphere about its centre, are these with c = 0: V0 and S0 are t^3 / 3
/// and t^2.
///
/// *Cylinders over a sphere.* In cylindrical coordinates (alpha, v, r) about the object's axis, c the foot of
/// the base's centre, v counted from there along the unit vector d, K = |c|^2 - delta^2:
///
///     r = (K + v^2) / (2 q(alpha)),   q = |c| cos alpha - delta,   dV = r (r - delta) / 3 d alpha dv,
///     dS = (K + v^2) / (2 q^2) sqrt(E^2 + v^2) d alpha dv,         E^2 = |c|^2 + delta^2 - 2 |c| delta cos
///     alpha,
///
/// alpha = 0 towards the base: elementary in v.
///
/// *Hollow cones over a sphere.* Let S and K be the sine and cosine of half the angle, w the axis, D the way
/// from the apex to the base's centre, D = h0 w + m, and P = h0 S + R0. Over the half-plane from the axis in
/// the direction e(alpha), with n = S w - K e the wall's normal there and g = K w + S e along it, nu = R0 +
/// D.n = P
/// - K m.e, gamma = D.g and Q^2 = nu^2 + (D.e')^2, the bisector is at
///
///     D + t u = l g + r n,   y = l - gamma,   t = r + R0 = (y^2 + Q^2) / (2 nu),
///
/// and with its distance from the axis, W = S l - K r = S (y + gamma) + K R0 - K t,
///
///     dV = t W / 3 d alpha dy,   dS = W sqrt(y^2 + Q^2) / nu d alpha dy,
///
/// as the part of the surface parallel to the wall is W d alpha dy, and 1 - u.n = nu / t: elementary in y.
///
/// *Tips* of hollow tubes and cones over a sphere, on the axis: v and l are the same there for all alpha. A
/// face that holds one has, besides the integrals along its edges, that of the same integrand from there all
/// around, by the trapezoidal rule, which converges geometrically for periodic functions.
///
/// *Over a cylinder, unless axes are skew.* t = C(y) / (2 beta(w)), so with beta' the derivative by the angle
///
///     dV = C^2 / (8 beta^2) d theta dy,   dS = C / (2 beta^2) sqrt(beta^2 + beta'^2 + C'^2 / 4) d theta dy,
///
/// elementary in y: C is linear, or (y - c_y)^2 plus a constant. Hollow spheres and tubes along the base have
/// the radius -R: C and beta are less than 0.
///
/// *Sides of the box over a cylinder*, and planes half-way to a twin of its: dV = (normal.p - normal_y y) / 2
/// dS, and a form f of degree d in q has the integral of f normal.(q x dq) / (d + 2) along the boundary.
///
/// *Skew cylinders of the base's radius* over a cylinder: a graph z = - steep X Y over the plane of both
/// axes' directions, from half-way between these on (skew_axes.hpp). dV is a polynomial there, and dS =
/// sqrt(1 + steep^2 (X^2 + Y^2)) dX dY: both have antiderivatives along rays in the plane.
///
/// *Other skew cylinders*, hollow ones and hollow cones: dS = sqrt(t^2 + t_theta^2 + t^2 t_y^2) d theta dy.
/// The integrals over y are found by quadrature, in parts that keep clear of the singularities of t; where
/// these would be too many, in parts of which the worst are halved first, and what they leave out is
/// estimated.
///
/// Points of curves that are not exact are taken along their rays to each bisector. So an error of the curve
/// changes a face's volume, but the sum of those on its two sides only to second order.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "../../primitives/bases/axial_terms.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/charts/chart.hpp"
#include "mixed_integrals.hpp"
#include "span_integrals.hpp"

namespace vcell {

struct SkewAxes;

namespace radial_integrals {

using span_integrals::SpanPoint;

/// A curve's direction from the base's centre or axis, its derivative, and the height on a cylinder.
struct Ray {
    std::array<double, 3> u, du;
    double y;
    /// How fast the curve leaves its place, seen from there: what the rounding of du is a part of. Where the
    /// curve runs along the ray next to nothing of it is du.
    double rate;
};

/// d theta on a cylinder: x = sin, z = cos.
inline double turn(const Ray& ray) { return ray.u[2] * ray.du[0] - ray.u[0] * ray.du[2]; }

/// What a boundary element with the face on its left adds to the face's volume and area, and estimates of
/// what quadrature along the ray left out.
struct Share {
    double volume, area;
    double volume_rest = 0, area_rest = 0;
};

/// Spheres, planes, walls, hollow spheres and the cap over a sphere.
struct RoundFace {
    /// Integrals of an ellipsoid are those from its near pole: of a face that has the far one they are less
    /// than the face's by the whole. Those of a closed one, an ellipsoid as well or a sphere about the base's
    /// centre, are what is left when its means times the solid angle are taken off.
    enum class Shape { Flat, Paraboloid, Hyperboloid, Ellipsoid, Closed };
    Shape shape;
    Vec3 axis;                ///< b
    double d1, d2, c, delta;  ///< of a paraboloid d1 only; of an ellipsoid delta = d1 + d2
    double root;              ///< sqrt(d1 d2)
    /// t = k / (e0 + e1 z)
    double k, e0, e1;

    RoundFace(const RadialBaseProblem& problem, FormId form);
    double least_distance() const { return d1; }
    bool is_closed() const { return shape == Shape::Closed; }
    bool is_ellipsoid() const { return shape == Shape::Ellipsoid; }
    /// Takes an ellipsoid for a closed one where that has the better bounds. `distance`: the range of t on
    /// the face's edges, more or less; most < least without any.
    void choose_integrals(const std::array<double, 2>& distance);
    /// The volume and area of a whole closed one or ellipsoid, divided by 4 pi, to rounding.
    Share mean() const;
    /// What b.(p x dp) is multiplied by at distance t: a number, or an array of them.
    template <class T>
    struct Factors {
        T volume, area;
    };
    template <class T>
    Factors<T> factors(const T& t) const;
    /// Bounds on how volume and area change, to first order, where a stretch of a curve with near <= t <= far
    /// leaves its place: times its length and the distance.
    double volume_slope(double near, double far) const;
    double area_slope(double near, double far) const;
    double distance(const Ray& ray) const;
    Share share(const Ray& ray) const;
    Share size(const Ray& ray) const;

private:
    /// A closed one that is at the distance t everywhere.
    void set_concentric(double t);
};

/// Points of a face's boundary: one of them, and how far apart they are.
struct Around {
    Vec3 near = Vec3::Zero();
    double extent = std::numeric_limits<double>::infinity();

    /// Where integrals start along an axis on which `near` is at v: at 0, or where that is far from a small
    /// face at v. What rounding moves points sideways counts with the distance from there.
    double start(double v) const { return std::abs(v) > 4 * extent ? v : 0; }
};

/// Cylinders over a sphere; hollow ones with delta = -R - R0. Then K, r = t + delta and the root have the
/// other sign, and so have dV and dS; but the base sees these faces from their other side.
struct TubeFace {
    Vec3 axis, foot;          ///< d, c
    double length, delta, K;  ///< length: |c|
    double first;             ///< along the axis, from the foot: integrals start there
    double side;              ///< -1: hollow

    TubeFace(const RadialBaseProblem& problem, FormId form, const Around& face);
    /// A tube that pierces the base comes nearest in its tips.
    double least_distance() const {
        return side > 0 && K < 0 ? -delta : 0.5 * std::abs(side * length - delta);
    }
    /// What lies between the place where integrals start and a hollow one's tip, all around the axis. A
    /// face that holds the tip has it besides what its edges add up to. Truncation is estimated from two
    /// rules, rounding is to first order, doubled.
    Share until_tip(const BisectorTip& tip) const;
    double distance(const Ray& ray) const;
    Share share(const Ray& ray) const;
    Share size(const Ray& ray) const;

private:
    /// On a ray: its part along the axis, the root of the quadratic, where it meets the bisector.
    struct Point {
        double A, R, t;
    };
    Point point(const Ray& ray) const;
};

/// Hollow cones over a sphere.
struct ConeFace {
    Vec3 axis, out;  ///< w, m
    double S, K, rho, h0, P;
    double C;       ///< P^2 - K^2 |m|^2
    double length;  ///< |m|
    double first;   ///< y at which integrals start

    ConeFace(const RadialBaseProblem& problem, FormId form, const Around& face);
    double least_distance() const;
    /// As of a TubeFace.
    Share until_tip(const BisectorTip& tip) const;
    double distance(const Ray& ray) const;
    Share share(const Ray& ray) const;
    Share size(const Ray& ray) const;

private:
    /// On a ray: its part along the axis, what radial_form.hpp has for A, the root of the quadratic, where it
    /// meets the bisector.
    struct Point {
        double along, A, root, t;
    };
    struct Foot;
    Point point(const Ray& ray) const;
    Foot foot(const Ray& ray, const Point& p) const;
    void set_level(Foot& f) const;
    Share until(const Foot& f, double y) const;
};

/// Everything but skew cylinders and hollow cones over a cylinder.
struct TurnedFace {
    Vec3 b;
    double b0;
    double side = 1;  ///< -1: hollow
    /// C = K + slope v + [is_round] v^2, v = y - start. Round: slope = 0.
    double start, K, slope;
    bool is_round;
    double first;  ///< v at which integrals start. Not round: 0
    double least;

    TurnedFace(const RadialBaseProblem& problem, FormId form, const Around& face);
    double least_distance() const { return least; }
    double distance(const Ray& ray) const;
    Share share(const Ray& ray) const;
    Share size(const Ray& ray) const;

private:
    double slope_square(const Ray& ray, double beta) const;
};

/// Walls over a cylinder (is_wall()), and planes next to its axis, which are taken as they are: rays that
/// hardly meet them tell nothing.
struct FlatFace {
    Vec3 normal;    ///< unit, outward
    Vec3 point;     ///< of the plane, near the face
    double offset;  ///< normal.p = offset

    FlatFace(const Plane& side, const Vec3& near);
    /// Half-way to a cylinder along the base that has its radius, and is so near that rays hardly meet the
    /// plane over most of the face; of others none.
    static std::optional<FlatFace> to_twin(const RadialBaseProblem& problem, FormId form, const Around& face);
    double least_distance() const { return std::numeric_limits<double>::infinity(); }
    Share share(const SpanPoint<double>& p) const;
    Share size(const SpanPoint<double>& p) const;
};

/// Where the common perpendicular of the base's axis, y, and another one meets the former, how far apart they
/// are there, and the square of the sine of their angle. Pre: they are not parallel, and `axis` is unit.
struct AxesApart {
    double foot, apart, square;

    AxesApart(const Vec3& point, const Vec3& axis);
};

/// Skew cylinders and hollow ones, and hollow cones, over a cylinder.
struct SkewFace {
    /// As primitives/forms/radial_form.hpp has them with the lengths of axial_terms.hpp, y from `origin`.
    double c0, c1, c2, b0, a0, slope, side;  ///< side = -1: hollow
    Vec3 b, a;
    double origin;
    /// The bisector's point over y in the direction u is |far0 + y far_y + t (far_t + far_u.u)| away from the
    /// object's axis.
    double far0, far_y, far_t;
    Vec3 far_u;
    double start;
    double least;
    std::vector<BisectorTip> tips;  ///< of the whole bisector

    SkewFace(const RadialBaseProblem& problem, FormId form, const Cylinder& cylinder, const Around& face);
    /// Takes the face of a hollow tube or cone, with the coefficients of AxialTerms.
    SkewFace(const RadialBaseProblem& problem, FormId vessel, const Around& face);
    double least_distance() const { return least; }
    double distance(const Ray& ray) const;
    Share share(const Ray& ray) const;
    Share size(const Ray& ray) const;
    /// May a tip lie between `start` and a point of the span? In its direction e what is between them is
    /// e^2 log |e| near the tip, of which rules tell less than they do of analytic integrands.
    bool may_pass_tip(const span_integrals::PowerSpan& span) const;
};

/// Cylinders of the base's radius over a cylinder, skew to it (skew_axes.hpp). Nothing is left out along the
/// way to an edge, and next to a twin, where rays hardly meet the graph, the edge's points are taken as they
/// are.
struct GraphFace {
    /// A curve's point, and the ray that sees it.
    struct Place {
        const SpanPoint<double>& curve;
        const Ray& ray;
    };

    SkewFace rays;
    Vec3 x, y, z, foot;  ///< as in SkewAxes, z away from the base; foot: on the base's axis
    double x0, y0, half_apart, steep;
    double bend;     ///< steep times the base's direction along x and along y
    Vec2 near;       ///< a place of the face along x and y, from the foot: angles count from there
    bool is_narrow;  ///< hardly met by rays
    bool is_far;     ///< from the crossing

    /// None where the radii differ, the axes are in one plane, or so nearly that the graph is steep and tells
    /// less than rays do.
    static std::optional<GraphFace> of(const RadialBaseProblem& problem, FormId form, const SkewFace& heights,
                                       const Around& face);
    double least_distance() const { return rays.least_distance(); }
    Share share(const Place& place) const;
    Share size(const Place& place) const;
    /// How far a curve's point at the distance t is from the face.
    double gap(const SpanPoint<double>& p, const Ray& ray, double t) const;

private:
    GraphFace(const SkewFace& heights, const SkewAxes& axes, const Around& face);
    struct Point {
        Vec2 at, way;
        double condition;
    };
    Point point(const Place& place) const;
    /// What the way across the base's axis has along the normal z + steep (Y x + X y).
    double along_normal(const Vec2& from_crossing) const;
    double element(const Vec2& from_crossing) const;
    static double swept(double w);
};

}  // namespace radial_integrals

/// A face, to be measured along its edges.
using RadialFace =
    std::variant<radial_integrals::RoundFace, radial_integrals::TubeFace, radial_integrals::TurnedFace,
                 radial_integrals::FlatFace, radial_integrals::SkewFace, radial_integrals::GraphFace,
                 radial_integrals::ConeFace>;

/// Over a cylinder integrals along the axis start at the height of `face.near`.
RadialFace make_radial_face(const RadialBaseProblem& problem, FormId form,
                            const radial_integrals::Around& face);

/// The bisector's least distance from the base's centre or axis, where that is a minimum inside the base's
/// stretch; infinite if there is none.
double least_distance(const RadialFace& face);

/// The signed solid angle between a curve (control points (p, w)) and its chord, which turns less than half a
/// turn about the base's centre. Error: as that of add_span().
Integral angle_above_chord(std::span<const Eigen::Vector4d> points, bool is_conic, Chart chart);

/// How far the rays' points on the bisectors are from the curve (`from_curve`) and from each other
/// (`apart`), the largest at some points of the spans. No right side: apart is from the curve, too.
struct RadialGap {
    double from_curve = 0, apart = 0;
};

/// What an edge's span adds to its two faces, to the length and to the flat end of a cylinder's cell.
struct RadialIntegrals {
    struct Side {
        Integral volume, area;
    };
    std::array<Side, 2>
        sides;  ///< left, right; each for the face on its left of the span in its own direction
    Integral length;
    Integral end_area;                                                           ///< t^2 / 2 d theta
    std::array<double, 2> distance{std::numeric_limits<double>::infinity(), 0};  ///< range of t
    RadialGap gap;                                                               ///< of add_span()

    RadialIntegrals& operator+=(const RadialIntegrals& o);
};

/// Of a rational quadratic over a sphere base that lies on both bisectors; control points (p w, w),
/// canonical. Pre: both sides are RoundFaces. Error: truncation as proven in quadrature.hpp, with as many
/// points as bring it to some 2^-40 of the integrand's size; rounding to first order, doubled.
void add_conic(const std::array<Eigen::Vector4d, 3>& points, const RadialFace& left, const RadialFace& right,
               RadialIntegrals& sum);
/// Adds the integrals along a segment between flat bisectors over a sphere base.
void add_segment(const Vec3& from, const Vec3& to, const RadialFace& left, const RadialFace& right,
                 RadialIntegrals& sum);
/// Adds those along any curve (control points (p, w)) that is nearly on both bisectors, seen from its points'
/// feet. No right side: a rim. Error: truncation estimated from two rules (integrate_estimated()), but for
/// the length of a conic (a line included), where it is proven; rounding to first order, doubled.
void add_span(std::span<const Eigen::Vector4d> points, bool is_conic, Chart chart, const RadialFace& left,
              const RadialFace* right, RadialIntegrals& sum);

}  // namespace vcell
