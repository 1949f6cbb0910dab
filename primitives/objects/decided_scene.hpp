/// The scene as decided: the one room between a scene as read and everything that computes with it.
///
/// Lengths are taken in a unit of the scene's own, a power of two of its extent. So what is computed is the
/// same, bit for bit, for a scene and for the scene times any power of two; and numbers stay far from both
/// ends of the double range, where a product of a few of them would be rounded to nothing. Directions stay
/// what they are.
///
/// A cap competes as objects do: points whose clearance from a base is p are as far from its like about the
/// same centre or axis, of radius R0 + 2 p and seen from within, or from the plane 2 p before it. So it is
/// one of the decided scene's objects, and what is true of those is true of it.
#pragma once

#include "scene.hpp"

namespace vcell {

struct DecidedScene {
    Scene scene;      ///< lengths over `unit`; with a probe the cap is its last object, Site::number_of_cap
    double unit = 1;  ///< a power of two, in the scene's own unit of length
    double moved =
        0;  ///< what that has rounded, in `unit`: nothing, but for numbers below 2^-1000 of the extent

    /// The site of the cap as an object. Pre: there is a probe.
    Site cap() const { return Site::object(scene.number(scene.objects.size() - 1)); }
};

/// Is it the cap? Of a decided scene.
inline bool is_cap(const Scene& decided, std::size_t object) {
    return decided.probe && object + 1 == decided.objects.size();
}

/// The cap of a base, as the object that it is. Its size is rounded; about a ball it is decided as exactly
/// where it is (sphere_base.hpp). Pre: no vessel.
Object cap_of(const Object& base, double probe);

/// The same scene, the cap being its last object. Pre: there is a probe.
Scene with_cap(Scene scene);

/// The unit is about the box's diagonal, but not so much smaller than the largest coordinate that this would
/// exceed 2^200 of it. Pre: validate(scene) has passed.
DecidedScene decide(const Scene& scene);

}  // namespace vcell
