/// Numbers as bytes, and bytes as text.
#pragma once

#include <array>
#include <bit>
#include <string>
#include <string_view>

namespace vcell {

/// Bytes of numbers in little endian, whatever the machine's order is.
class Bytes {
public:
    template <class T>
    void add(T value) {
        auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
        if constexpr (std::endian::native == std::endian::big) bytes = reversed(bytes);
        text_.append(bytes.data(), bytes.size());
    }
    void add_text(std::string_view text) { text_ += text; }
    const std::string& text() const { return text_; }

private:
    template <std::size_t N>
    static std::array<char, N> reversed(const std::array<char, N>& bytes) {
        std::array<char, N> result{};
        for (std::size_t i = 0; i < N; ++i) result[i] = bytes[N - 1 - i];
        return result;
    }

    std::string text_;
};

/// [RFC 4648, section 4], padded.
std::string base64(std::string_view bytes);

}  // namespace vcell
