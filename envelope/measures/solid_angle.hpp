/// The solid angle of a face of a closed bisector, the cap or that with a hollow sphere, from what bounds it.
///
/// Seen from the base's centre the face is a part of the unit sphere, between arcs of circles {n.u = h}. With
/// any direction b the signed areas of the geodesic triangles (b, from, to) and of the segments between arcs
/// and chords,
///
///     tan(E / 2) = b.(from x to) / (1 + b.from + from.to + to.b)      [Van Oosterom & Strackee 1983]
///     S = 2 atan(h tan(phi / 2)) - h phi                              (the sector less its triangle)
///
/// phi being the arc's angle about n, add up to the face's area, but for multiples of 4 pi: no rule of
/// quadrature is needed, and neither the number of the face's boundaries nor angles in its corners. Where
/// other curves bound the face, with tubes, their segments are integrated elsewhere.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "../../core/quadrature/bounded_sum.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell {

class SolidAngle {
public:
    struct Value {
        double angle, error;
    };

    /// An arc of {n.u = h} between unit vectors, shorter than half a turn, with the face on its left, or
    /// (sign = -1) on its right.
    void add(const Vec3& from, const Vec3& to, const Vec3& n, double h, double sign) {
        arcs_.push_back({from, to, n, h, sign});
    }

    /// An arc of any curve between unit vectors less than half a turn apart, likewise. `segment`: the signed
    /// area between the arc and its chord, known to `error`.
    void add(const Vec3& from, const Vec3& to, double segment, double error, double sign) {
        add(from, to, from.cross(to).normalized(), 0, sign);
        segments_.add(sign * segment, error);
        has_segments_ = true;
    }

    /// A direction in the face, or outside of it and its boundary.
    struct Place {
        Vec3 direction;
        bool is_inside;
    };

    /// In [0, 4 pi]; all of the sphere without arcs. Error: rounding, to first order, doubled, of vectors
    /// that are known to some roundings. Of a face that the arcs tell neither from nothing nor from all the
    /// enclosure has both, unless the place tells: with nothing but arcs of circles on the boundary, all of
    /// them so far from it that what is nearer to it is no face that might be nothing.
    Value value(const std::optional<Place>& place = std::nullopt) const;

private:
    struct Arc {
        Vec3 from, to, n;
        double h, sign;
    };

    // No point of the boundary is nearer to the direction than that; 0 where that is not known.
    double distance_from(const Vec3& direction) const;

    std::vector<Arc> arcs_;
    BoundedSum segments_;
    bool has_segments_ = false;
};

}  // namespace vcell
