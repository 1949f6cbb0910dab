/// Files in a zip archive.
#pragma once

#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace vcell {

struct ZipEntry {
    std::string_view name;  ///< in ASCII, folders before a slash
    std::string content;
};

/// The entries, stored as they are, all of the same time: the same entries are the same bytes [Zip20].
/// Throws WriteError for what takes more than 4 GB.
void write_zip(std::ostream& out, const std::vector<ZipEntry>& entries);

}  // namespace vcell
