/// The void network of a diagram as tables.
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

}  // namespace vcell
