/// Base64 read back, digit by digit: what files hold as text is compared as bytes.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <string>

namespace vcell::testing {

inline std::string from_base64(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t word = 0;
    int bits = 0;
    for (const char c : text) {
        if (c == '=') break;
        const std::size_t digit = digits.find(c);
        REQUIRE(digit != digits.npos);
        word = word << 6 | static_cast<std::uint32_t>(digit);
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes += static_cast<char>(word >> bits & 255U);
    }
    return bytes;
}

}  // namespace vcell::testing
