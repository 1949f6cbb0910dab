/// What objects are to a base cylinder's axis as it is given. That turns by a few 2^-53 with its frame
/// (cylinder_forms.hpp), and what touched or crossed the axis before would come off it.
#pragma once

#include <algorithm>
#include <array>

#include "cylinder_forms.hpp"

namespace vcell::cylinder_forms {

struct GivenAxis {
    const CylinderFrame& frame;
    const Cylinder& base;

    // Is C = 0 or less in a stretch of the base? A ball about a point of its axis would come off that as the
    // base turns, by so little that nothing near it could be told.
    bool is_touched_by(const Ball& ball, const std::array<double, 2>& stretch) const {
        if (frame.turn == 0) return false;
        const Vec3 center(ball.cx, ball.cy, ball.cz);
        const ExactVector d(scaled_axis(base.axis)), c = ExactVector(center) - ExactVector(base.point),
                                                     across = cross(c, d);
        const Exact delta = Exact(ball.rho) - base.radius, y = frame.turned(frame.from_origin(center)).y;
        return (dot(across, across) - delta * delta * dot(d, d)).sign() != Sign::Positive &&
               y >= frame.norm * stretch[0] && y <= frame.norm * stretch[1];
    }

    // Likewise of a tube across the base, where the axes are nearest to each other: a thicker one may hold it
    // there, and a thinner one touch it from within.
    bool is_touched_by(const Cylinder& cylinder, const std::array<double, 2>& stretch) const {
        if (frame.turn == 0) return false;
        const AxesCrossing at(base, cylinder);
        const Exact apart = dot(at.way, at.across), delta = Exact(cylinder.radius) - base.radius;
        const Sign room = (apart * apart - delta * delta * at.square).sign();
        if (at.across.is_zero() || room == Sign::Positive ||
            (room == Sign::Negative && cylinder.radius < base.radius))
            return false;
        const Exact y = frame.height(base, at);
        return y >= at.square * frame.norm * stretch[0] && y <= at.square * frame.norm * stretch[1];
    }

    // Planes between crossing axes turn by this angle at most, as lengths of directions are rounded.
    double crossing_turn(const Cylinder& tube) const {
        constexpr double rounding = 0x1p-103;
        if (!frame.crossing(base, tube)) return 0;
        const Vec3 d = base.axis.stableNormalized(), e = tube.axis.stableNormalized();
        return rounding / std::min((e - d).norm(), (e + d).norm());
    }
};

}  // namespace vcell::cylinder_forms
