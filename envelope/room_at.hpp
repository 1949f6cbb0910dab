/// What room a bisector's point has among the others.
#pragma once

#include <algorithm>
#include <limits>

#include "../primitives/bases/radial_base.hpp"
#include "object_distance.hpp"

namespace vcell {

/// How far a point of a form's bisector is inside the sides of the box, those of the floor among them, and by
/// how much other objects are farther than the base, at the clearance given: whichever is less. Canonical;
/// off by a few roundings of the coordinates.
inline double room_at(const RadialBaseProblem& problem, FormId own, const Vec3& p, double clearance) {
    double room = std::numeric_limits<double>::infinity();
    for (const FormId f : problem.objects.ids()) {
        if (f == own) continue;
        const Object& object = problem.objects[f];
        if (problem.sites[f].front().is_object()) {
            room = std::min(room, distance_from(object, p) - clearance);
            continue;
        }
        const double beyond = signed_distance_from(object, p);
        const bool is_floor = std::ranges::find(problem.floor, f) != problem.floor.end();
        room = std::min(room, is_floor ? beyond : -beyond);
    }
    return room;
}

}  // namespace vcell
