/// What room a bisector's point has among the others.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

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

/// Is a form the nearest at a point of its bisector, `reach` away from the base's centre or axis? None where
/// another one is as near but for rounding.
inline std::optional<bool> shows_at(const RadialBaseProblem& problem, FormId own, const Vec3& p,
                                    double reach) {
    const double room = room_at(problem, own, p, reach - problem.chart.radius);
    double size = reach;
    for (const Object& o : problem.objects) size = std::max(size, place_of(o).norm());
    constexpr double rounding = 0x1p-44;  // far more than any
    if (std::abs(room) <= rounding * size) return std::nullopt;
    return room > 0;
}

}  // namespace vcell
