/// PNG files.
#pragma once

#include <iosfwd>

#include "../io/pictures/raster.hpp"

namespace vcell {

/// Was the program built with libpng?
bool has_png();

/// Eight bits a channel. Throws WriteError where libpng says no. Pre: has_png().
void write_png(std::ostream& out, const Image& image);

}  // namespace vcell
