/// What the motion of a scene when it is decided (its sides, planes and base by a few roundings) does to a
/// cell's vertices and edges.
///
/// At a vertex three equations d_i(p) - d_0(p) = 0 hold, of objects with the base, or that of a side of the
/// box. Their gradients are the rows g_i - g_0 of a matrix M, g the unit vectors from the feet, or the side's
/// normal; two rows may be taken for their difference g_i - g_j, which hardly turns where objects are nearly
/// alike, and whose equation changes by what objects move against each other alone, mostly next to nothing. A
/// ball next to the base ball is such a difference, too. Where objects move by m at most, other equations
/// change by 2 m, so that the vertex moves by 2 m times the sum of the lengths of the columns of M^-1 to
/// first order; by twice that, if rows turn so little on the way that M^-1 times their change is 1/4 at most
/// [Deuflhard04, Thm. 2.1, Newton-Kantorovich]. Where no three rows allow that, bisectors touch: the sites'
/// distances still agree within what they did and 2 m, but the place along the bisectors is not told
/// (CellVertex::is_touching). An edge is moved across by two rows, likewise, with bounds of what they are all
/// along a part of it, which are sought as far as its position tells; trims keep their distances from the
/// curve.
#pragma once

#include "lift.hpp"

namespace vcell {

/// Adds to the errors of vertices and edges what these motions may do (tubes around a tube move by
/// `moves.all`, against each other, too); the diagonal of the box at most. What gives way to a tie counts
/// where the sites of an edge or a vertex name one.
void add_scene_motion(LiftedCell& lifted, const SceneMoves& moves);

}  // namespace vcell
