/// Where away from a face's edges the excess of another ball may have its least value.
///
/// On the bisector of the base and its own object o the excess of a rival r is stationary where its gradient
/// is parallel to that of o's: n_r - u to n_o - u, with the gradients n of their distances and u of the
/// clearance. All three are of length one, and a line meets the unit sphere in two points: there n_r = u or
/// n_r = n_o. Of balls that says that the rival's centre lies between the point and its foot on the base, its
/// centre or its axis, or that it is in line with the own ball's centre. If it is the farther one of the two
/// then, its excess is the distance of the centres less the difference of the radii, and that is not negative
/// where it does not hold the own ball. What is left are two places, each on a ray that leaves a focus of the
/// bisector, o's centre or the base's, through the rival's centre, and behind that. A ray from a focus meets
/// the bisector once at most, and behind a centre on the focus's own side: there is one place at most.
#pragma once

#include <optional>

#include "../../core/small_vector.hpp"
#include "../../primitives/scene.hpp"
#include "midrad.hpp"
#include "space.hpp"

namespace vcell::check {

/// A ball that holds one point.
struct Spot {
    Vec3 center;
    double radius;
};

class LeastPlaces {
public:
    LeastPlaces(const Object& base, const Sphere& own);

    /// The only places where on the bisector the rival's excess may have a negative least value: two where it
    /// is not clear on which side the rival is. None: where they are cannot be told.
    std::optional<SmallVector<Spot, 2>> of(const Sphere& rival) const;

private:
    using V = Vector<MidRad>;
    using Kind = Surface<Interval>::Kind;

    struct Ray {
        V start, way;   // the way has length one
        MidRad length;  // to the rival's centre
    };
    static Ray ray(const V& start, const V& through);
    MidRad along_from_own(const Ray& ray) const;
    Ray ray_from_base(const V& through) const;
    MidRad along_from_base(const Ray& ray) const;

    Kind kind_;
    V base_, direction_;  // of the base: its centre or a point of it, its normal or axis
    V own_, from_base_;   // the own ball's centre, and the way there
    MidRad own_radius_, base_radius_, difference_;  // of the radii, the own one less the base's
    MidRad height_;                                 // of the centre over a base plane
};

}  // namespace vcell::check
