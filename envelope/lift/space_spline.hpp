/// Splines in space for the edges that are no conics: quintic spans with a certified distance from the true
/// arc, and with them the trims on both sides.
///
/// The unknowns are X = (p, t): a point in canonical coordinates and its distance t from the base's centre or
/// axis, or from a base plane. An edge lies where three equations G(X) = 0 hold, that of the base and those
/// of its two sites (R0 = 0 for a base plane):
///
///     sphere (c, rho), cylinder       G = |p - c| (distance from the axis) - (t + delta),   delta = rho - R0
///     base sphere, cylinder           the same with delta = 0, about 0 (about the y axis)
///     base plane                      G = z - t
///     sphere over a base plane        its paraboloid, which is quadratic in (x, y) and linear in t
///     plane                           G = its distance + R0 - t
///     wall                            G = the distance to a side of the box, to an end of the stretch, over
///     a
///                                     base plane to the bisector of any plane
///
/// Their gradients are (g, -1), g the unit vector from the foot point, and (g, 0) for walls. Seen along the
/// edge the left site is nearest on the left, so the edge runs along (g_left - g) x (g_right - g), g = grad
/// of the base's distance (walls: g_wall instead of the difference).
///
/// Where cylinders of one radius have crossing axes, left and right depend on each other over the crossing,
/// and the trisector has a node. Each of its curves lies in a plane between the axes; the plane's equation
/// then stands for that of the right site, except for the trim. Where the sites are two balls or two tubes
/// that are all but alike, the difference of their equations does: its gradient, which tells where the edge
/// is, is as small as the objects are apart, and changes by as little.
///
/// Both ends of a span lie on the arc. First and second derivative at both ends, by the length of the curve
/// (p, t), follow from the equations and make a quintic that errs by the sixth power of the span. Steps of
/// Newton's method take it to the arc at four places in between, chosen so that the quintic through all six
/// errs by a small part of that (quintic_nodes.hpp). The patches' coordinates are quotients of linear
/// functions of X (PatchCoordinate); the trims have their values at the same six places. A span that is not
/// good enough is divided at points of the arc, found by Newton's method, into as many parts as the sixth
/// power asks for.
///
/// *The certificate.* Let P(s) = (p, t)(s) be the fitted span.
///
/// 1. Residuals. d^2 - (t + delta)^2 along the span is a polynomial of degree 10 (planes and walls: G, of
///    degree 5) that all but vanishes at those six places: that bounds it closely. Divided by d + t + delta
///    it bounds |G(P(s))| <= e.
/// 2. Place. Take four equations F(X) = 0, a convex D around the span (what is within some room of the hull
/// of
///    its control points), M the Jacobian in its middle, B nearly the inverse of M, B_i its columns. Within r
///    of a point at distance d from a centre or axis the unit vector from there turns by asin(r / d) at most;
///    that bounds the rows of F' - M, and so q >= |I - B F'| in D. Let q < 1. Then X - B F(X) contracts, so F
///    is one-to-one in D; and a solution lies within x = sum |B_i| |F_i(P)| / (1 - q) of P, if D contains the
///    ball of this radius [Deuflhard04, sec. 2.1].
/// 3. The curve. F = (G, N . (X - P(s))) with N the unit null vector of the gradients in the middle. So in D
///    the curve G = 0 is a graph over N, and meets the slice across N through each P(s) within x. Since
///    N . P(s) increases, these points make up the curve's arc between the slices of P(0) and P(1), in the
///    edge's direction.
/// 4. Which arc. Let A be a point of the curve within a of P(0), and c_i bound the curvature of G_i, 1 / d in
///    D. On the way from P(0) to A |G_i| <= |G_i(P(0))| + c_i a^2 / 8; so the slices in between meet the
///    curve, too, as near as step 2 says. If that is in D, A lies on the graph of step 3. So consecutive
///    spans follow one arc, which starts at the edge's start and in its direction; and it reaches the edge's
///    end with the last span only: no other span's D holds the end between its slices. So it is the edge.
///    Of the diagram's pieces only guesses are taken, and for closed edges that one point is near the edge.
/// 5. Trims. F = (G_base, G_site, n_u - u(s) d_u, n_v - v(s) d_v) for coordinates n / d: step 2 bounds the
///    distance of the patch's point at (u, v)(s) from P(s). Where these rows all but depend on each other (a
///    needle seen from the base's centre) that point is computed instead: (P, w)((u, v)(s)) - P(s) w is a
///    polynomial of degree 25, whose coefficients bound it.
///
/// A span too long for one D, or for a small q, is halved for the proof. Where an arc ends in a point with
/// dependent gradients (objects that touch) or passes one closely (axes that cross but for rounding) spans of
/// the tolerance's length cannot be proved so: they are chords, as good as intervals enclose that part of the
/// diagram's piece. All of it in double: residuals and gradients carry bounds of their rounding.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "../../primitives/bases/radial_base.hpp"
#include "space_arc.hpp"

namespace vcell {

struct SpaceFitError {
    /// Of the curve (x, y, z, t) from the arc; infinite if it is not proved.
    double curve = 0;
    /// Of the patches' points at the trims from the space curve at the same parameter.
    double trims = 0;
    std::optional<Vec3> unproved = {};  ///< canonical, where one of them is infinite
    Vec3 worst = Vec3::Zero();          ///< canonical, where they are largest
};

/// The point in which three sites are met, from one within `near.error` of it, and a bound of the distance
/// that is left: at the level of rounding, whatever the chart made of the scene's size. None where this
/// bound is no smaller, or not proved (nearly dependent gradients).
std::optional<SpaceEnd> settle_point(const RadialBaseProblem& problem, const std::array<SpaceSite, 3>& sites,
                                     const SpaceEnd& near);

/// What the fits of a cell may still cost. When it is spent spans stay as they are.
struct FitEffort {
    std::size_t spans = 20'000;   ///< that are tried
    std::size_t cells = 400'000;  ///< of the chart where arcs are looked for
};

/// Appends the spans of an arc. tolerance: length, for both errors. The result exceeds it only where rounding
/// blurs the arc and the diagram's pieces are wider, where the ends are not known as well (four times their
/// error bounds it then), where a divisor of a patch's coordinate is not positive, or when `effort` is spent,
/// and says so.
SpaceFitError fit_space_spline(const RadialBaseProblem& problem, const SpaceArc& arc, double tolerance,
                               std::vector<SpaceSpan>& spans, FitEffort& effort);

/// Fits likewise over the base plane z = 0, where t is the distance from it.
SpaceFitError fit_spline_over_plane(const SpaceArc& arc, double tolerance, std::vector<SpaceSpan>& spans,
                                    FitEffort& effort);

}  // namespace vcell
