/// Objects that are no balls in a box that repeats: what moves by its edges leave them as they are.
///
/// Images of a tube are as many as the axis has places in the plane across it that edges move it to. They
/// lie apart from each other if the axis leaves the box through a side that does not repeat, or if it is
/// along a whole combination of edges, after which the tube *closes on itself*: the shortest one is its own
/// period. Otherwise they come as near to each other as one likes, and no diagram has them. A plane or a
/// vessel is to be the same after every edge.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "image_tree.hpp"

namespace vcell::whole {

/// Edges are combined in no larger numbers than this: a tube that closes later is taken for one that does
/// not.
constexpr int most_edges_of_period = 16;

/// Whole combinations of edges that make up all those which leave the object as it is; empty where none does.
/// None: the object does not fit into a box that repeats. Directions in doubles count as what they were
/// meant to be, within a 2^-40. Pre: the object is no ball; validated.
std::optional<std::vector<Image>> own_periods(const Lattice& lattice, const Object& object);

/// Turns an object into its own periods, exactly. Returns a bound on the distance that it is moved by within
/// the first of them, seen from its point. Pre: own_periods() has these.
double align(const Lattice& lattice, std::span<const Image> periods, Object& object);

/// Names the one image that stands for all that differ by sums of these periods. Throws InputError where
/// that is no Image, which takes objects thousands of edges apart.
Image representative(const Image& image, std::span<const Image> periods);

}  // namespace vcell::whole
