/// The least clearance along an edge of three balls' equal distances.
#pragma once

#include <array>
#include <optional>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell::whole {

/// A point of an edge: known up to `error`, in any direction, and its clearance likewise.
struct EdgePoint {
    Vec3 point = Vec3::Zero();
    double clearance = 0, error = 0;
};

/// An arc of a trisector, between its ends; `middle` is a point of it somewhere between them.
struct EdgeArc {
    std::array<EdgePoint, 2> ends;
    EdgePoint middle;              ///< its clearance is not needed
    bool is_closed = false;        ///< it is all of the trisector; its ends are one point of it
    std::optional<double> length;  ///< an upper bound
};

/// Encloses the least clearance along an arc of the trisector of three balls. Where the errors do not tell
/// whether the trisector's narrowest point is on the arc, the enclosure is that of both answers. None where
/// no precision encloses that point. Pre: no two of the balls lie in each other.
std::optional<Interval> least_clearance(const std::array<Sphere, 3>& balls, const EdgeArc& arc);

}  // namespace vcell::whole
