/// Objects that hold others, decided exactly: what is held is nowhere nearer than its holder.
#pragma once

#include "../../core/numbers/sign.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell::check {

/// Does `holder` contain all of `held`? A plane holds what lies in it, balls and cylinders are solid. Of a
/// cylinder the axis may have any length.
bool contains(const Object& holder, const Object& held);
/// Does the base contain all of an object, or as a plane have it behind its front?
bool base_contains(const Object& base, const Object& held);

/// The side of a plane that the base is wholly on: Positive where its normal points. Zero where that is not
/// known: of base planes and tubes that are not parallel to it. Pre: the plane does not cut the base.
Sign side_of_base(const Plane& plane, const Object& base);
/// Has a plane the base on one side and the object on the other? A point on the base's side is no farther
/// from the plane than from the object then. Pre: the plane does not cut the base.
bool is_across(const Plane& plane, const Object& base, const Object& object);

}  // namespace vcell::check
