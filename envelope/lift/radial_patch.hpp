/// Rational parametrizations of the bisectors of a sphere or cylinder base.
///
///     S(u, v) = P(u, v) / w(u, v),   polynomials of degree at most two in u and in v,
///
/// canonical coordinates (primitives/bases/radial_base.hpp). (u, v) is oriented like the chart,
/// counter-clockwise seen from outside the cell: dS/du x dS/dv points away from the base. Inverse:
/// parameters(). With n(u), W(u) the half angle's normal about the patch's own axes, or n(u, v), W(u, v) the
/// stereographic one, delta = rho - R0:
///
/// *Planar.* (u, v) are lengths in a plane: in that of a box side or a plane bisector (spheres of the base's
/// radius, parallel or crossing cylinders of the base's radius), degree (1, 1); in the plane of an object
/// over a sphere base, where with d the centre's distance S lies (u^2 + v^2 + d^2 - R0^2) / (2 (R0 + d))
/// before it: polynomial, (2, 2). Affine in space: a trim is an affine image of the space curve, on the same
/// knots and weights.
///
/// *Graph.* A cylinder of the base's radius over a cylinder base, skew to it: (u, v) are lengths along both
/// axes' plane (skew_axes.hpp). S is a polynomial, (1, 1), and a trim an affine image of the space curve: one
/// patch will do however far the face reaches around the base. A steep one has strips (face_patches.hpp), so
/// that control points are near the face.
///
/// *Stereographic.* Spheres over a sphere base, centre c: S = (|c|^2 - delta^2) n / (2 (c.n + delta W)), (2,
/// 2), about the direction of c: the surface's points at infinity are the circle u^2 + v^2 = (|c| + delta) /
/// (|c| - delta), and the pole lies beyond them. A rectangle that reaches across them has no patch; then it
/// is
///
/// *Confocal.* Let q be a direction of that circle, x across it in the plane of q and c. u = |p| - p.q is
/// constant on paraboloids about q with their focus in the base's centre, v is the length along y = q x x.
/// Where the surface is met, x.p = a - b u with a = sqrt(|c|^2 - delta^2) / 2, b = delta / (2 a), and |p| +
/// p.q = (x^2 + v^2) / u:
///
///     S = x (a - b u) + v y + q ((a - b u)^2 + v^2 - u^2) / (2 u),
///
/// (2, 2), and its weight u is positive on all of the surface: every rectangle will do. No coefficient
/// cancels where the object all but touches the base and its bisector is a needle. Linear in (p, t): a trim
/// has the space curve's weights.
///
/// *AboutObject.* Cylinders over a sphere base, seen from the object's axis: c is the foot of the base's
/// centre, u the tangent of half the angle about the axis, 0 towards the base, v the length along it from c:
/// S = c + v d + (|c|^2 - delta^2 + v^2) n / (-2 (c.n + delta W)), (2, 2). The bisector is met where c.n <
/// -delta W, an interval about 0: no pole comes near.
///
/// *Tubes that pierce the base* have delta < 0 and bisectors with two tips on their axes, which they open
/// from. Over a sphere base they are AboutObject in the same form, all around the axis, u = 0 in the
/// direction from that to the face, in several patches: in a tip v is one and the same for all u.
///
/// *Vessels over a sphere base.* Ellipsoids are Stereographic, but about `middle`: that direction's opposite
/// is the only one that a patch lacks. Their weights are positive all over, those of control points over a
/// wide rectangle in a higher degree only, which patch() then has. Hollow cylinders are AboutObject with
/// delta = R + R0, and u = 0 in the direction from their axis to the face; the weight is positive all around.
/// A face that reaches around the axis has several patches (face_patches.hpp), and so has one that holds a
/// tip, on the axis, where v is one and the same for all u.
///
/// Hollow cones likewise, with v along the wall's generators from the apex on: with half the angle's sine S
/// and cosine K, the axis w, D = -apex, e(u) across the axis, n = S w - K e and g = K w + S e,
///
///     S(u, v) = apex + (v^2 n + 2 v (R0 g + (D.w) e - (D.e) w) + (|D|^2 - R0^2) n) / (2 (R0 + D.n)),
///
/// (2, 2), since with r the distance from the wall (R0 + r)^2 = |v g + r n - D|^2 is linear in r, and
/// (D.n) g - (D.g) n is D turned by a right angle in the half-plane of e.
///
/// *AboutBase.* Everything else over a cylinder base: u is the tangent of half the angle about the base's
/// axis, counted from a direction of choice; v = y for spheres (2, 2), planes and parallel cylinders (2, 1).
/// For a cylinder of direction d (d_y > -1) through a, v = ((y - a_y) + (p - a).d) / (1 + d_y), the mean of
/// the feet on both axes in a scale of their own. With q(v) = a + v d and the part across the base's axis
/// written q',
///
///     S = (0, y, 0) + t n / W,   t = C W / (2 (q.n + delta W)),   C = |q'|^2 - delta^2,
///     y = a_y + v - (t n / W - a).d' / (1 + d_y):
///
/// (2, 2), and t is that of the parallel cylinder through q(v). It follows from C Q^2 - 2 B Q - A^2 = 0,
/// which factors over v: the conics u = const meet infinity in rational points, and v = const are the lines
/// through one of them. (Half angles about both axes would be rational parameters, too, but singular on whole
/// lines of the surface where the axes are closer than |delta|.) The axes' distance h > |delta|: regular for
/// either sign of d. Otherwise v is constant on two lines of the surface, one on each side of the crossing;
/// they are not met on the half of the base where y and n.d have one sign, y counted from the foot of the
/// common perpendicular. Next to parallel axes these lines are far out for d_y > 0, and that sign is taken.
///
/// *Vessels over a cylinder base* are AboutBase. Spheres and parallel tubes as above. For the others, with
/// the letters of primitives/forms/radial_form.hpp, lengths such that A = w.u - sin of half a cone's angle (0
/// in a tube), B = B0 - w_y y A and C = c0 + c1 y + c2 y^2, y counted from a height of the face: w_y^2 - c2
/// is the square of k, 1 in a tube and the cosine in a cone, and with m = w_y + k or w_y - k
///
///     v = y + A t / m,   t = C(v) / (2 (B0 + (c1 / (2 m) -+ k v) A)),   y = v - A t / m,
///
/// (2, 2) again, as C - 2 B t + A^2 t^2 has the part (A t + w_y y)^2 - k^2 y^2. The weight is above 0 all
/// over the bisector. v is constant, and (u, v) no coordinates, on straight lines of the surface that run
/// from where the base's axis comes out of the vessel to a tip; for either m they reach the same tip from the
/// other side. A face beside such a line has the larger m on one half of the base and the other on the other
/// half.
///
/// *Next to a tip over a cylinder base* none of these is good on both lines, and faces on both sides of it
/// are AboutObject. With the vessel's axis a, e(u) across it, S and K the sine and cosine of half a cone's
/// angle (0 and 1 in a tube), g = K a + S e along the wall and n = S a - K e its normal; of a tube that
/// pierces the base, whose points lie beyond its surface, K = -1. From the tip o, rho away from the base in
/// its direction d, points are o + l g + (t - rho) n, and with a direction b of the base's axis v = l - y:
/// t^2 = |p|^2 - y^2 is linear in t and in l for constant v, and with c = a.b
///
///     S(u, v) = o + v ([S - d.a - v (K + c) / (2 rho)] e + [K + d.e + v (S + b.e) / (2 rho)] a) / w,
///     w = 1 - S d.a - K c - S c v / rho + e.[(K - c) d + (d.a - S) b] + (K v / rho) b.e,
///
/// (2, 2). In the tip, v = 0, w is the square of a linear function of u: on one line through the tip v is
/// constant, and (u, v) no coordinates. For the other b it is another line: a patch is for directions nearer
/// to that. In a vessel the line ends where the base's axis comes out of the wall; from there another line
/// goes on in the same half plane, on which v is constant for the other b (tip_sectors.hpp).
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "../../primitives/bases/axial_terms.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "coordinate_surface.hpp"
#include "skew_axes.hpp"

namespace vcell {

class RadialPatch : public CoordinateSurface {
public:
    RadialPatch() = default;
    /// The patch of a form over a face. `middle`: a unit normal of the base in the middle of the face; of
    /// hollow tubes and cones a direction from their axis there. On
    /// AboutBase the angle counts from it. `y` (cylinder base): a height of the face. `wide`: for faces that
    /// reach far. Instead of Stereographic they are Confocal, about the direction at infinity opposite to
    /// `middle`; cylinders over a cylinder base take d for the half in which `middle` lies, where (with y on
    /// one side of the crossing) t grows with |v|: rectangles of (u, v) keep clear of the surface's points at
    /// infinity.
    RadialPatch(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y,
                bool wide = false);
    explicit RadialPatch(const SkewAxes& axes);
    /// Over a cylinder, about the axis of an object of which this is a tip. `middle`: a direction from that
    /// axis; for directions around it that are nearer to one of tip_lines(). `is_beyond`: with the other
    /// direction of the base's axis, for what lies beyond that line.
    static RadialPatch around_tip(const RadialBaseProblem& problem, FormId form, const BisectorTip& tip,
                                  const Vec3& middle, bool is_beyond = false);
    /// A cylinder's patch may be for half of a cylinder base only: n.half() >= 0 for its normals n.
    const std::optional<Vec3>& half() const { return half_; }

private:
    void set_plane(const Vec3& point, const Vec3& normal);
    void set_paraboloid(double distance, const Vec3& normal, double radius);
    void set_stereographic(const Vec3& c, double delta, double power, const Vec3& middle, bool wide);
    void set_confocal(const Vec3& z, double length, double delta, double power, const Vec3& middle);
    /// side: -1 in a hollow tube. middle: where the face of one is, or of a tube that pierces the base; of
    /// others null.
    void set_about_object(const Vec3& axis, const Vec3& point, double delta, double side, const Vec3* middle);
    void set_in_sphere(const Vec3& c, double delta, double power, const Vec3& middle);
    void set_in_cone(const HollowCone& vessel, double radius, const Vec3& middle);
    void set_about_base(const Vec3& middle, const Vec3& b, double b0, const std::array<double, 3>& C,
                        double start = 0);
    void set_in_vessel(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y);
    void set_about_axes(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y,
                        bool wide);
    /// Adds half of `power` times n of stereographic coordinates about z.
    void add_direction(double power, const Vec3& z);

    std::optional<Vec3> half_;
};

/// A line of the bisector from a tip over a cylinder on which v of around_tip() is one and the same, for one
/// direction of the base's axis.
struct TipLine {
    Vec3 across;  ///< the unit vector from the object's axis to it
    /// Where it runs to the base's axis, coming out of a wall there, from which on another line lies in the
    /// same half plane, on which v is so for the other direction. The product of a point with `inwards` is
    /// positive on the line from the tip, and negative on the one beyond, which lies over the base's normal
    /// `normal`.
    struct Beyond {
        Vec3 inwards, normal;
    };
    std::optional<Beyond> beyond{};
};
/// For the y axis and its opposite.
std::array<TipLine, 2> tip_lines(const RadialBaseProblem& problem, FormId form, const BisectorTip& tip);

}  // namespace vcell
