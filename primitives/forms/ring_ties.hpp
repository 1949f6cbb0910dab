/// Over a cylinder: which forms tie with others all along a ring y = const, and are not nearer beside it.
///
/// Forms without roots are met at t = 1 / Q with Q = 2 (b.u + b0) / C(y) at the unit normal u. Where (b, b0)
/// of several are multiples k > 0 of one vector their Q have one sign at u, and where it is positive the one
/// with the least C / k is nearest, a quadratic in y: which of them is nearest is a question of y alone, and
/// where some tie they tie all along a ring. So it is with balls of the base's radius, tubes of that radius
/// along it and sides of the box whose centres, axes and normals lie on one side of the axis in one plane
/// through it: rows of lattices. Of three that tie along a ring one is nearest on each side of it, and the
/// others, if they are nearest anywhere, are so elsewhere: on each side up to where C / k comes down to that
/// of the nearest one again. Nor is one nearer that touches another along a ring, or that ties with a nearer
/// one at an end of the region.
///
/// A form that is left out where it ties, and about there, is no nearer than one that is not left out there:
/// beside the ring one of the two is nearer than it is, and on the ring these are not left out because of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "radial_form.hpp"

namespace vcell {

/// Forms by their places in the list.
struct RingTie {
    std::uint32_t form;
    /// The nearest ones next to the ring, on the side of lesser and of greater y. One form twice where the
    /// ring is an end of the region, or touches.
    std::uint32_t before, after;
    std::optional<AxialEnd> end;        ///< of the region, that the ring is
    Interval y;                         ///< of the ring
    std::optional<Interval> elsewhere;  ///< of the other ring along which `before` and `after` tie
    /// Here `form` is nowhere nearer than the nearer of the two. Ends are rounded inwards, or infinite.
    double from, to;
};

/// All ties of that kind along rings over which no other form on the same side is nearer, between y0 and y1,
/// exact. Takes the number of forms times the logarithm of it, and in each plane times that of the rings.
std::vector<RingTie> find_ring_ties(std::span<const RadialForm> forms, double y0, double y1);

}  // namespace vcell
