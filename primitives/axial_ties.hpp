/// Over a cylinder: which forms of planes and cylinders along the base tie with two others along a generator,
/// and are never nearer.
///
/// Along the axis nothing changes about these: such a form is met at t = 1 / F(u), F(u) = (b.u + b0) / (c0 /
/// 2) at the unit normal u, and the greatest F is nearest. Where F of one form is a mean of those of two
/// others, l F_a + (1 - l) F_b with 0 < l < 1, it is less than the greater of these, except where all three
/// are equal. So it is with the fourth line or tube of the base's radius on a circle around a line of points
/// as far from all: in square lattices, say. Where coordinates are rounded, as of hexagonal lattices, F_j
/// comes out nearer by parts of 2^-53 over a strip as narrow: a tie is taken for granted up to `narrow_tie`.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../core/radial_form.hpp"

namespace vcell {

/// The middle one of three forms is nowhere nearer than the nearer of the others by more than this part of
/// the distance at which they tie.
constexpr double narrow_tie = 0x1p-40;

/// Of three forms the middle one, by their places in the list.
struct AxialTie {
    std::uint32_t middle;
    std::uint32_t before, after;  ///< the nearer ones on both sides, as the angle grows
    bool is_exact;                ///< otherwise up to narrow_tie

    bool operator==(const AxialTie&) const = default;
};

/// All ties of that kind along generators over which nothing in the list is nearer. Forms that change along
/// the axis do not matter. Takes the number of forms times that of the generators over which the nearest one
/// changes.
std::vector<AxialTie> find_axial_ties(std::span<const RadialForm> forms);

}  // namespace vcell
