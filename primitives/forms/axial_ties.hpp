/// Over a cylinder: which forms of planes and cylinders along the base tie with two others along a generator,
/// and are never nearer.
///
/// Along the axis nothing changes about these: such a form is met at t = 1 / F(u), F(u) = (b.u + b0) / (c0 /
/// 2) at the unit normal u, and the greatest F is nearest. Where F of one form is a mean of those of two
/// others, l F_a + (1 - l) F_b with 0 < l < 1, it is less than the greater of these, except where all three
/// are equal. So it is with the fourth line or tube of the base's radius on a circle around a line of points
/// as far from all: in square lattices, say. Where coordinates are rounded, as of hexagonal lattices, F_j
/// comes out nearer by parts of 2^-53 over a strip as narrow, up to `narrow_tie`.
///
/// Nor is a form nearer whose F such a mean touches from above over the generator on which all three are
/// equal, as a plane's half-way between two others that are as far from the axis, across it.
///
/// Where it is no mean of the two, a form that ties with them over a generator is no nearer about it: F_a -
/// F_j is zero over two generators at most and positive from the other one up to this one, F_b - F_j from
/// this one up to its other one. So it is with tubes of any radii that touch one circle; beyond these
/// generators the form may be the nearest one.
///
/// The coefficients of F are those of a tube about m whose radius is that of the base plus delta,
///
///     F = 2 (m.u + delta) / N,  N = |m|^2 - delta^2;     m = 2 X / M,  delta = 2 w / M,  M = |X|^2 - w^2 = 4
///     / N
///
/// with X = 2 m / N and w = 2 delta / N. So every F near F_j belongs to a tube near the middle one, and the
/// mean of F_a and F_b that is next to F_j to one that is never nearer than these two: `move` bounds how far
/// distances from the middle one change when it gives way to that.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "radial_form.hpp"

namespace vcell {

/// The middle one of three forms is nowhere nearer than the nearer of the others by more than this part of
/// the distance at which they tie.
constexpr double narrow_tie = 0x1p-40;

/// Output accuracy, in parts of what a cell reaches: where a tie gives way for rounding, the lines in which
/// two of three meet are no farther apart. Next to twins they are for far less rounding than elsewhere.
constexpr double narrow_place = 0x1p-32;

/// Of three forms the middle one, by their places in the list.
struct AxialTie {
    std::uint32_t middle;
    std::uint32_t before, after;  ///< the nearer ones on both sides, as the angle grows
    double move;                  ///< 0: exact; a bound on how far the middle one gives way otherwise

    bool operator==(const AxialTie&) const = default;
};

/// All ties of that kind along generators over which nothing in the list is nearer. Forms that change along
/// the axis do not matter. Takes the number of forms times that of the generators over which the nearest one
/// changes.
std::vector<AxialTie> find_axial_ties(std::span<const RadialForm> forms);

/// A form that ties with two others over a generator, exactly, and has a nearer one on each side of it.
struct PassingTie {
    std::uint32_t form;
    std::uint32_t before, after;  ///< the nearer ones on both sides, as the angle grows
    /// In each of these ranges of x in the chart of a cylinder the form is nowhere nearer than the nearer of
    /// the two. About a generator next to the chart's ends there are two ranges. Their ends are rounded
    /// inwards, or infinite.
    std::vector<std::array<double, 2>> ranges;
};

/// All ties of that kind over generators over which nothing in the list is nearer, but those of forms that
/// are AxialTie::middle. Forms that change along the axis do not matter. Takes as long as find_axial_ties().
std::vector<PassingTie> find_passing_ties(std::span<const RadialForm> forms);

}  // namespace vcell
