/// The scene as decided: the one room between a scene as read and everything that computes with it.
///
/// Lengths are taken in a unit of the scene's own, a power of two of its extent. So what is computed is the
/// same, bit for bit, for a scene and for the scene times any power of two; and numbers stay far from both
/// ends of the double range, where a product of a few of them would be rounded to nothing. Directions stay
/// what they are.
#pragma once

#include "scene.hpp"

namespace vcell {

struct DecidedScene {
    Scene scene;      ///< lengths over `unit`
    double unit = 1;  ///< a power of two, in the scene's own unit of length
    double moved =
        0;  ///< what that has rounded, in `unit`: nothing, but for numbers below 2^-1000 of the extent
};

/// The unit is about the box's diagonal, but not so much smaller than the largest coordinate that this would
/// exceed 2^200 of it. Pre: validate(scene) has passed.
DecidedScene decide(const Scene& scene);

}  // namespace vcell
