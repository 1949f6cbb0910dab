/// Faces as integrands: volume below them, their area and that of their shadow on the base, as integrals
/// along their edges. Patches have no part in it: over each base point the scene gives the height of a
/// bisector, and edges bound the shadows.
///
/// Everything is in the base's own frame (frame.hpp).
///
/// With t the distance from the base's plane, centre or axis along the unit normal u, an object over the foot
/// f has the equation C - 2 beta t - alpha^2 t^2 = 0:
///   |f + t u - c|^2 = (t + delta)^2 for balls, the same without the part along the axis d for tubes, and
///   s (n (f + t u) + D) = t - R for planes, where delta = rho - R, R the base's radius or 0.
/// For the inside of balls and tubes of radius R0 the same holds with delta = -R0 - R, C, beta and t + delta
/// being negative, and of the two roots of a tube's equation the other one. In a cone with half an angle's
/// sine S and cosine K, m the way from its apex and m' that across its axis d,
///   K |m' + t u'| = L - t (1 - S d u),   L = S d m + R:
/// C = L^2 - K^2 |m'|^2, beta = L (1 - S d u) + K^2 m' u', C - 2 beta t + (d u - S)^2 t^2 = 0, of which the
/// lesser root counts, and 1 - u n' = sqrt(beta^2 - (d u - S)^2 C) / (L - t (1 - S d u)).
/// The bisector's normal is along u - n', n' the unit direction from the object's nearest point, so its area
/// over a piece of the base is that of the piece at distance t times sqrt(2 / (1 - u n')); and 1 - u n' =
/// sqrt(beta^2 + alpha^2 C) / (t + delta), for planes 2 beta.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "densities.hpp"
#include "equation.hpp"
#include "frame.hpp"
#include "pierced_section.hpp"
#include "saddle.hpp"
#include "vessel_section.hpp"

namespace vcell::check {

/// Over a plane: heights h + g (q - a).
struct LinearHeight {
    std::array<MidRad, 2> gradient, apex;
    MidRad half_at_apex, steepness;
};
/// Over a plane, a ball's: (s^2 + e) / (2 k), s the distance from its axis.
struct Paraboloid {
    std::array<MidRad, 2> axis;
    MidRad half_of_e, half_by_k, one_by_k2;  ///< e / 2, 1 / (2 k), 1 / k^2
};
/// About a sphere: t = K / (A z + B), z the cosine of the angle to an axis; balls, planes and box sides.
///
/// In a hollow sphere it is closed, and volume and area may lack all of it: they are those of what edges
/// bound if the face has no end of the axis at z = -1. Shadows are from a direction whose opposite it surely
/// has not.
struct Revolved {
    Revolved(const Triad<MidRad>& axis, const MidRad& K, const MidRad& A, const MidRad& B, const MidRad& E,
             bool is_paraboloid);

    Triad<MidRad> axis;
    MidRad A, B, E;  ///< E = A^2 - B^2, 0 for a plane
    bool is_paraboloid;
    MidRad b1, K2, volume;                              ///< A + B, K^2, K^3 / (6 (A + B)^2)
    std::optional<Triad<MidRad>> start = std::nullopt;  ///< of shadows, in a hollow sphere
};
/// Over a plane: heights that grow in proportion to the distance from an apex.
struct ConeHeight {
    Equation equation;
    std::array<MidRad, 2> apex;
    MidRad at_apex;
};
/// Over a plane: the same from a line across instead, where the apex is far away or nowhere.
///
/// With n the axis' direction over the plane, v = n (q - a) for a point a of the line, D = n (a - apex) and
/// kappa = 1 / D, the line cuts what lies between apex and q at lambda = 1 / (1 + kappa v) of the way. From
/// there to q the integrals are those from the apex times 1 - lambda^2 and 1 - lambda^3, of which 1 - lambda
/// = kappa v lambda; what is left out depends on the direction from the apex alone, and adds up to nothing
/// around a face that is on one side of it. Then det(q - apex, dq) comes with a factor of kappa, and is as
/// small as the face: kappa (q - apex) = kappa (q - a) + m.
struct RuledHeight {
    Equation equation;
    std::array<MidRad, 2> start, along, m;  ///< a, n, m
    MidRad kappa, fall;                     ///< fall: kappa times the apex's height
};
/// About a cylinder: a side of the box, in coordinates of its own. As seen from the axis it may turn by
/// almost half a circle within no length at all, where the axis ends close to it.
struct Flat {
    Triad<MidRad> normal;  ///< outwards
    Triad<MidRad> corner;
    MidRad corner_above;  ///< the side
    Triad<MidRad> flux;   ///< of (x, y, 0) / 2 through the side below p: grows by flux (p - corner)
    MidRad flux_at_corner;
};
/// About a cylinder: a plane's, of which the distance from the axis grows evenly along each generator: what
/// lies between the start's height and an edge's is told at once.
struct Tapered {
    Equation equation;
    MidRad start;
};
/// Any other: integrated from a point of the base to the edge: along a line of the plane, along a great
/// circle, or on a cylinder along the generator from a height.
struct Fan {
    enum class Base { plane, sphere, cylinder } base;
    Equation equation;
    Triad<MidRad> start;
    /// About a sphere, in a hollow tube or cone: where volume and area start along the wall instead.
    std::optional<MidRad> along_wall = std::nullopt;
    /// Volume and area of a tube that pierces the base start in a tip, as they are smooth from there on.
    std::optional<Pierced> pierced = std::nullopt;
};

/// What a site's equation is. None: on which side of a plane the base is cannot be told from the points,
/// which are of the face's edges.
std::optional<Equation> equation_of(const Scene& scene, const Frame& frame, const Site& site,
                                    std::span<const Triad<double>> points);

using Shadow =
    std::variant<LinearHeight, Paraboloid, Revolved, ConeHeight, RuledHeight, Flat, Saddle, Tapered, Fan>;

/// Where a face's edges run, in the frame: points on them, and control points, whose hull holds them. Control
/// points may lie where the face cannot.
struct Outline {
    std::vector<Triad<double>> points, controls;
};

/// The integrand of a face over the base. By the outline a place to start from is chosen and the side of a
/// plane. None: it cannot be told.
std::optional<Shadow> shadow(const Scene& scene, const Frame& frame, const Site& site,
                             const Outline& outline);

/// The solid angle of what an edge bounds, per ds, from a direction on. Its opposite counts as outside.
template <class T>
T solid_angle(const Triad<MidRad>& from, const Place<T>& p);

/// A Fan has no volume and area here, which take a second variable, but its shadow.
template <class T>
Densities<T> densities(const Shadow& shadow, const Place<T>& p);
/// Gives them where what p has along the axis, times w, is known better than from its coordinates.
template <class T>
Densities<T> densities(const Revolved& shadow, const Place<T>& p, const T& along_axis);
/// Is it integrated over a plane of its own, and not along rays?
inline bool is_over_plane(const Shadow& s) {
    return std::holds_alternative<Flat>(s) || std::holds_alternative<Saddle>(s);
}
/// The area of the face for that of the base at its distance, of a Fan too.
MidRad steepness(const Shadow& shadow, const Place<MidRad>& p);
/// The integrand over sigma in [0, 1] too: what lies between the start and the edge, at one place of it, or
/// at as many as T has lanes. What does not depend on sigma is computed once.
template <class T>
class FanSection {
public:
    /// Keeps a reference to the fan.
    FanSection(const Fan& fan, const Place<T>& p);

    Densities<T> at(const T& sigma) const;
    /// Integrates the shadow alone, over all sigma: it takes no second variable.
    T shadow() const;

private:
    const Fan& fan_;
    Triad<T> n_;  ///< over a plane, from the start; about a sphere, homogeneous; on a cylinder, the normal
    T turn_;
    T q_, size_, sum_;  ///< about a sphere: the share along the start, the length, and both
    T share_, tau2_, turn_of_tau_;
    T rise_;  ///< on a cylinder
    std::optional<VesselSection<T>> vessel_;
    std::optional<PiercedSection<T>> beyond_tip_;
};

}  // namespace vcell::check
