/// The void network of a diagram as tables, and as OpenPNM reads it.
#pragma once

#include <iosfwd>

#include "../../envelope/whole/void_network.hpp"

namespace vcell {

/// Three tables, as those of diagram_file.hpp, with an empty line between two:
/// - `sphere diameter error`: Di, Df, Dif, and Df_x, Df_y, Df_z along the box's edges;
/// - `vertex x y z clearance error touching sites`;
/// - `edge first second image sites bottleneck bottleneck_error length length_error`.
/// Sites are separated by blanks: objects by number, with their image behind it where it is not 0, 0, 0,
/// "3(0,-1,0)", and sides of the box, "box:-x".
void write_network(std::ostream& out, const VoidNetwork& network);

/// One table with commas between columns, as OpenPNM's network_from_csv() reads it [Gostick16]: a line has a
/// vertex as a pore and an edge as a throat, columns are blank where there are no more of either.
/// - `pore.coords[0..2]`, `pore.diameter` of the sphere about the vertex, `pore.error` of both;
/// - `throat.conns[0..1]`, pores counted from 0, ascending, `throat.image[0..2]` of the second one in edges
/// of the box,
///   `throat.diameter` at the bottleneck, `throat.error` of that, `throat.length` (blank: none is proved).
/// Closed edges, which join no pores, are left out.
void write_openpnm(std::ostream& out, const VoidNetwork& network);

}  // namespace vcell
