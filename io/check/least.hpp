/// Where away from a face's edges the excess of another site may have its least value.
///
/// On the bisector of the base and its own object o the excess of a rival r is stationary where its gradient
/// is parallel to that of o's: n_r - u to n_o - u, with the gradients n of their distances and u of the
/// clearance. All three are of length one, and a line meets the unit sphere in two points: there n_r = u or
/// n_r = n_o. Of balls that says that the rival's centre lies between the point and its foot on the base, its
/// centre or its axis, or that it is in line with the own ball's centre. If it is the farther one of the two
/// then, its excess is the distance of the centres less the difference of the radii, and that is not negative
/// where it does not hold the own ball. What is left are two places, each on a ray that leaves a focus of the
/// bisector, o's centre or the base's, through the rival's centre, and behind that. A ray from a focus meets
/// the bisector once at most, and behind a centre on the focus's own side: there is one place at most. The
/// bisector of a base ball and a plane is that of a base plane and a ball.
///
/// Of a side of the box the gradient is a constant m, and n_o - u is parallel to it where u is n_o reflected
/// in the plane across m: there is one place at most (stationary_place).
///
/// A plane's excess is l - t where it has the base on its side. Where n_r = u that is what the plane is away
/// from the base's centre and its radius more, and where n_r = n_o so with the own ball: not negative unless
/// that is behind the plane. A base ball that is farther from the plane than `apart` leaves all excesses
/// beyond it below -apart; where edges tell that they are not, what a face has there is enclosed in it, and l
/// is least in it at its one place.
///
/// On a side of the box the excess of a plane is less than linear by a distance, which is convex: it is least
/// at the edges. That of a ball is |p - c| - |p - o| up to radii, with c on the base's side, as good as its
/// reflection: it is least where the line from o through c meets the side, if c is nearer to the side.
#pragma once

#include <cmath>
#include <optional>

#include "../../core/small_vector.hpp"
#include "../../primitives/objects/scene.hpp"
#include "../../primitives/objects/site.hpp"
#include "midrad.hpp"
#include "space.hpp"

namespace vcell::check {

/// A ball that holds one point.
struct Spot {
    Vec3 center;
    double radius;
};

/// The only places where an excess may have a negative least value.
using Spots = SmallVector<Spot, 2>;

/// Of balls, on the bisector of the base and a ball.
class LeastPlaces {
public:
    /// `farthest`: from the own centre, places beyond which do not count.
    LeastPlaces(const Object& base, const Sphere& own, double farthest = HUGE_VAL);

    /// Two where it is not clear on which side the rival is. None: where they are cannot be told.
    std::optional<Spots> of(const Sphere& rival) const;
    /// About a base ball: does the ray that leads to the place, or both, miss a ball? Then no place is in it.
    static bool do_rays_miss(const Sphere& base, const Sphere& own, const Sphere& rival, const Vec3& center,
                             double radius);

private:
    using V = Vector<MidRad>;
    using Kind = Surface<Interval>::Kind;

    struct Ray {
        V start, way;   // the way has length one
        MidRad length;  // to the rival's centre
    };
    static Ray ray(const V& start, const V& through);
    MidRad along_from_own(const Ray& ray) const;
    MidRad reach(const MidRad& numerator, const MidRad& denominator) const;
    Ray ray_from_base(const V& through) const;
    MidRad along_from_base(const Ray& ray) const;

    Kind kind_;
    V base_, direction_;  // of the base: its centre or a point of it, its normal or axis
    V own_, from_base_;   // the own ball's centre, and the way there
    MidRad own_radius_, base_radius_, difference_;  // of the radii, the own one less the base's
    MidRad height_;                                 // of the centre over a base plane
    double farthest_;
};

/// Of all sites, on a face of the base and a site.
class LeastPlacesOfSites {
public:
    LeastPlacesOfSites(const Scene& scene, const Site& own);

    /// None: where they are cannot be told. `apart`: more than what the face's edges may leave of the rival's
    /// excess.
    std::optional<Spots> of(const Site& rival, double apart) const;

private:
    using V = Vector<MidRad>;

    /// A ball, or a plane with its normal towards the face: what the bisector is equally far from.
    struct Focus {
        bool is_plane;
        V place;        // the centre, or the unit normal
        MidRad radius;  // of a plane, its distance from the origin
        MidRad distance(const V& p) const;
    };
    static Focus focus(const Sphere& ball);
    static Focus focus(const Plane& plane);
    std::optional<Spots> stationary_place(const V& m) const;
    std::optional<Spots> of_plane(const Plane& rival, double apart) const;
    std::optional<Spots> of_ball_on_side(const Sphere& rival) const;

    const Scene& scene_;
    std::optional<LeastPlaces> of_balls_;
    std::optional<Focus> base_, own_, side_;
};

}  // namespace vcell::check
