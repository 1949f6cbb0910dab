/// What the motion of a scene when it is decided (its sides, planes and base by a few roundings) does to a
/// cell's vertices and edges.
///
/// At a vertex three equations d_i(p) - d_0(p) = 0 hold, of objects with the base, or that of a side of the
/// box. Their gradients are the rows g_i - g_0 of a matrix M, g the unit vectors from the feet, or the side's
/// normal. Where objects move by m at most, each equation changes by 2 m, so that the vertex moves by 2 m
/// |M^-1| to first order; by twice that, if the rows do not turn too far on the way: with L = 2 / the least
/// distance from a centre or axis, which bounds by how much a row changes over a length, |M^-1|^2 L 2 sqrt(3)
/// m <= 1/4 is enough [Deuflhard04, Thm. 2.1, Newton-Kantorovich]. Otherwise, of nearly parallel bisectors,
/// nothing is known. An edge is moved across by two rows, likewise, with bounds of what they are all along a
/// part of it.
#pragma once

#include "cell.hpp"

namespace vcell {

/// Adds to the errors of vertices and edges what a motion by `moved` (a length) may do; the diagonal of the
/// box at most.
void add_scene_motion(Cell& cell, double moved);

}  // namespace vcell
