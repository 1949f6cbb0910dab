/// What a cell is made of as tables for spreadsheets and scripts, with the objects' own numbers and names.
#pragma once

#include <iosfwd>

#include "../../core/platform.hpp"
#include "../../envelope/cell.hpp"

namespace vcell {

// Tables: a header, then a line each, separated by tabs; numbers with the digits that read back to the same
// doubles,
// `-` where there is none. Sites are written as in cell files; names are those of the scene's objects.

/// face site name bisector area area_error estimated
void write_faces(std::ostream& out, const Cell& cell);

/// edge site1 site2 name1 name2 kind length length_error estimated dihedral dihedral_error
///
/// `dihedral` is the angle inside the cell, in degrees, at which the two faces meet in the middle of the
/// curve's parameters: 180 where they go on smoothly. Enclosed from the distances' gradients over the ball of
/// the edge's error; atan2 is taken to be within an ulp, as the C library says of its own. `-` where only one
/// face meets the edge, over the rim, or nothing is enclosed.
void write_edges(std::ostream& out, const Cell& cell);

/// vertex x y z clearance error touching sites names
void write_vertices(std::ostream& out, const Cell& cell);

/// extreme clearance clearance_error x y z error vertex edge face sites names, two lines, `least` and
/// `greatest`: clearance_places() of the cell. All but the first column is `-` where no place is proved.
void write_clearances(std::ostream& out, const Cell& cell);

/// x y z centroid_error xx yy zz yz zx xy second_error, one line: moments_of() the cell.
void write_moments(std::ostream& out, const Cell& cell);
/// Its columns, and a line of them.
inline constexpr const char* moment_columns = "x\ty\tz\tcentroid_error\txx\tyy\tzz\tyz\tzx\txy\tsecond_error";
void write_moment_line(std::ostream& out, const Moments& moments);

}  // namespace vcell
