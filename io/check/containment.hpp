/// Objects that hold others, decided exactly: what is held is nowhere nearer than its holder.
#pragma once

#include <cstdint>

#include "../../core/numbers/sign.hpp"
#include "../../primitives/objects/scene.hpp"

namespace vcell::check {

/// Does `holder` contain all of `held`? A plane holds what lies in it, balls and cylinders are solid. Of a
/// cylinder the axis may have any length.
bool contains(const Object& holder, const Object& held);
/// Does it contain what mirrors the base in that side of the box, a tube along it, or as a vessel have it
/// beyond its wall, or as a plane have it on one side and the base on the other? Then a point that is as far
/// from it as from the base is inside the side: false where that is not known.
bool contains_mirrored(const Object& holder, const Scene& scene, std::uint32_t side);
/// Does what mirrors the base in that side of the box, a plane whose normal leads there with all that is
/// behind the image, contain all of an object? Inside the side no point is nearer to that than to the base
/// then: false where that is not known.
bool mirrored_contains(const Scene& scene, std::uint32_t side, const Object& held);
/// Does the base contain all of an object, or as a plane have it behind its front?
bool base_contains(const Object& base, const Object& held);

/// The side of a plane that all of the base is on from which places in the box are seen, or in one twice as
/// large about its middle: Positive where its normal points. Zero where that is not known: where the plane
/// cuts a base plane or tube not far beyond. Pre: the plane does not cut the base in the box.
Sign side_of_base(const Plane& plane, const Scene& scene);
/// Has a plane on one side all of the base from which places in the box are seen, and on the other the
/// object? A point of the box on the base's side is no farther from the plane than from the object then. Pre:
/// the plane does not cut the base in the box.
bool is_across(const Plane& plane, const Scene& scene, const Object& object);

}  // namespace vcell::check
