/// Rotations of a scene with rational entries: objects stay exactly what they are to each other.
///
/// No rotation with rational entries takes every direction with rational components to a coordinate axis: the
/// direction's length would have to be rational. So it is the base that turns a little on the way, by a few
/// 2^-53, and nothing else does.
#pragma once

#include <array>

#include "../bases/canonical.hpp"
#include "exact_space.hpp"

namespace vcell {

/// norm times a rotation: the rows are orthogonal and of length `norm`, all entries exact.
struct ExactRotation {
    std::array<ExactVector, 3> rows;
    Exact norm;

    /// The rotation that takes `direction` to the coordinate axis `target`, up to an angle of a few 2^-53
    /// unless the direction's length is a double. Other coordinates than the direction's largest change no
    /// more than they must: axis-parallel directions give signed permutations. Pre: direction's largest
    /// component is in [1/2, 1).
    ExactRotation(const Vec3& direction, Eigen::Index target);

    /// norm times the rotation of p.
    ExactVector operator()(const ExactVector& p) const {
        return {dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)};
    }
    /// Of what the call operator returns: over norm, every component within 4u.
    Vec3 rounded(const ExactVector& p) const {
        return Vec3(nearest(p.x), nearest(p.y), nearest(p.z)) / nearest(norm);
    }
    Eigen::Matrix3d rounded() const;
    /// A bound on the angle (as its tangent) between the image of `direction` and the coordinate axis
    /// `target`.
    double turn(const Vec3& direction, Eigen::Index target) const;
};

}  // namespace vcell
