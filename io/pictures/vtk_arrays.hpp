/// Arrays of VTK's XML files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string_view>
#include <vector>

#include "bytes.hpp"

namespace vcell {

/// An array is written in base64, and the number of its bytes before them.
template <class Fill>
void write_array(std::ostream& out, std::string_view attributes, std::size_t bytes, Fill&& fill) {
    Bytes data;
    data.add(static_cast<std::uint64_t>(bytes));
    fill(data);
    out << "<DataArray " << attributes << " format=\"binary\">\n";
    out << base64(data.text()) << "\n</DataArray>\n";
}
template <class T>
void write_array(std::ostream& out, std::string_view attributes, const std::vector<T>& values) {
    write_array(out, attributes, sizeof(T) * values.size(), [&](Bytes& data) {
        for (const T& value : values) data.add(value);
    });
}

}  // namespace vcell
