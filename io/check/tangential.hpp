/// Oriented spheres and planes that one sphere touches: their tangential distances, and how excesses of these
/// grow beside that sphere.
///
/// Directions n of distances from balls and planes that such a sphere touches differ by
///     1 - n n' = D / (2 s s'),  D = |c - c'|^2 - (rho - rho')^2 = |c - c'|^2 - (s - s')^2,
/// the squared tangential distance. Of planes s is 1, with D = 2 (rho + the centre's distance) for one of
/// them and D = |n - n'|^2 for two.
#pragma once

#include <cmath>
#include <optional>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell::check {

/// Relative: what a few operations in a row may lose.
inline constexpr double kFew = 0x1p-49;
/// Bounds are computed in doubles, too.
inline constexpr double kAbove = 1 + 0x1p-40, kBelow = 1 - 0x1p-40;

inline double sum_of_magnitudes(const Vec3& v) { return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z()); }

/// A ball, or a plane with its normal towards the base.
struct Oriented {
    bool is_plane;
    Vec3 place;  ///< the center, or the unit normal
    double radius;
    Vec3 point;  ///< of a plane
};

/// Half the squared gradient of an object's excess, at least, in the points within `margin` of those where
/// that is below `size` and the clearance of the base lies in an interval. None: it cannot be told.
std::optional<double> growth_between(const Oriented& base, const Oriented& own, const Interval& clearance,
                                     double size, double margin);

/// The least singular value of the derivative of two objects' excesses, and the lesser growth of both.
struct Slopes {
    double both, growth;
};
/// The slopes beside two objects.
std::optional<Slopes> slopes_between(const Oriented& base, const Oriented& a, const Oriented& b,
                                     const Interval& clearance, double size, double margin);

/// A side of the box: its excess, the distance from it inwards, grows in one direction by one per length.
struct Inwards {
    int axis;
    double sign,
        place;  ///< the side is where the coordinate is `place`, and inside is where sign times it grows
};
/// The slopes beside an object and a side of the box.
std::optional<Slopes> slopes_beside(const Oriented& base, const Oriented& own, const Inwards& side,
                                    const Interval& clearance, double size, double margin);

}  // namespace vcell::check
