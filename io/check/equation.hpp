/// What a face's object says about the distance at which rays from the base meet the bisector.
#pragma once

#include <array>

#include "frame.hpp"

namespace vcell::check {

/// The equation of one object, in the frame.
struct Equation {
    enum class Kind { ball, tube, plane, side, cone } kind;
    Triad<MidRad> c;  ///< ball: centre; tube: a point of the axis; cone: apex; plane, side: unit normal
    Triad<MidRad> d;  ///< tube, cone: unit axis
    std::array<Triad<MidRad>, 2> across;  ///< tube: with d an orthonormal frame
    std::array<MidRad, 2> across_c;       ///< tube: the coordinates of c in it
    MidRad delta;                         ///< ball, tube
    bool is_hollow = false;               ///< ball, tube: a vessel
    MidRad offset;                        ///< plane: D; side: n p = offset on it
    double sign = 1;                      ///< plane: of the side where the base is
    MidRad radius;                        ///< plane, cone: R; hollow tube: -delta
    MidRad sine, cosine;                  ///< cone; of hollow tubes 0 and 1
};

}  // namespace vcell::check
