/// Arrays of .vtu files read back as bytes.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "base64.hpp"

namespace vcell::testing {

template <class T>
T take(const std::string& bytes, std::size_t& at) {
    T value;
    REQUIRE(at + sizeof(T) <= bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
}

/// The bytes of an array of a .vtu, after their number.
inline std::string array_of(const std::string& file, const std::string& name) {
    const std::size_t at = file.find("Name=\"" + name + "\""), begin = file.find(">\n", at) + 2,
                      end = file.find('\n', begin);
    REQUIRE(at != file.npos);
    const std::string bytes = from_base64(file.substr(begin, end - begin));
    std::size_t start = 0;
    CHECK(take<std::uint64_t>(bytes, start) == bytes.size() - 8);
    return bytes.substr(start);
}

}  // namespace vcell::testing
