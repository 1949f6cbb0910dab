#include "png.hpp"

#include <ostream>
#include <stdexcept>
#include <string>

#include "../io/files/files.hpp"
#ifdef VCELL_HAS_PNG
#include <png.h>
#endif

namespace vcell {

#ifdef VCELL_HAS_PNG

bool has_png() { return true; }

// libpng's simplified interface, which neither calls back nor jumps.
void write_png(std::ostream& out, const Image& image) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.bytes.data(), 0, nullptr) == 0)
        throw WriteError(std::string("PNG: ") + png.message);
    out.write(bytes.data(), static_cast<std::streamsize>(size));
}

#else

bool has_png() { return false; }
void write_png(std::ostream&, const Image&) { throw std::logic_error("vcell was built without libpng"); }

#endif

}  // namespace vcell
