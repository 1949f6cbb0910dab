#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "../../core/errors.hpp"

namespace vcell {

// [RFC 3629, section 4]: no overlong forms, no surrogates, nothing above U+10FFFF.
std::size_t utf8_length(std::string_view text) {
    const auto byte = [&](std::size_t i) -> unsigned {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const auto is_tail = [&](std::size_t i) { return (byte(i) & 0xC0) == 0x80; };
    const unsigned first = byte(0), second = byte(1);
    if (text.empty()) return 0;
    if (first < 0x80) return 1;
    if (first < 0xC2 || first > 0xF4 || !is_tail(1)) return 0;
    if (first < 0xE0) return 2;
    if (!is_tail(2)) return 0;
    if (first < 0xF0) {
        const bool overlong = first == 0xE0 && second < 0xA0;
        const bool surrogate = first == 0xED && second >= 0xA0;
        return overlong || surrogate ? 0 : 3;
    }
    const bool overlong = first == 0xF0 && second < 0x90;
    const bool too_large = first == 0xF4 && second >= 0x90;
    return !is_tail(3) || overlong || too_large ? 0 : 4;
}

std::string printable(std::string_view text) {
    constexpr std::size_t longest = 40;
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
        if (result.size() >= longest) return result + "...";
        const std::size_t length = utf8_length(text.substr(i));
        const unsigned char c = static_cast<unsigned char>(text[i]);
        if (length == 0 || c < 0x20 || c == 0x7F)
            result += '?';
        else
            result += text.substr(i, length);
        i += std::max<std::size_t>(length, 1);
    }
    return result;
}

std::string xml_escaped(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = std::max<std::size_t>(utf8_length(text.substr(i)), 1);
        const std::string_view c = text.substr(i, length);
        if (c == "<")
            result += "&lt;";
        else if (c == ">")
            result += "&gt;";
        else if (c == "&")
            result += "&amp;";
        else if (c == "\"")
            result += "&quot;";
        else if ((length == 1 && (c[0] & 0x80 || (c[0] < 0x20 && c != "\t" && c != "\n"))) ||
                 c == "\xEF\xBF\xBE" || c == "\xEF\xBF\xBF")
            result += "\xEF\xBF\xBD";  // U+FFFD
        else
            result += c;
        i += length;
    }
    return result;
}

std::string_view without_byte_order_mark(std::string_view text) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    if (text.starts_with(mark)) text.remove_prefix(mark.size());
    return text;
}

std::string_view next_line(std::string_view text, std::size_t& at) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = std::min(end + 1, text.size());
    return line.substr(0, line.find('#'));
}

std::string_view next_word(std::string_view& line) {
    constexpr std::string_view blanks = " \t\r";
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(blanks));
    line.remove_prefix(word.size());
    return word;
}

std::optional<double> to_double(std::string_view word) {
    double value = 0;
    const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (ec == std::errc::invalid_argument || end != word.data() + word.size()) return std::nullopt;
    // from_chars reports underflow like overflow and leaves the value alone; strtod tells them apart.
    if (ec == std::errc::result_out_of_range) return std::strtod(std::string(word).c_str(), nullptr);
    return value;
}

double parse_number(std::string_view word, std::size_t line_number) {
    const std::string where = fmt::format("line {}", line_number);
    // from_chars wants no '+', which other programs write.
    const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    const std::optional<double> value = to_double(word.substr(plus ? 1 : 0));
    if (!value)
        throw InputError(InputError::Kind::Syntax, InputError::no_object, where,
                         fmt::format("'{}' is not a number", printable(word)));
    if (!std::isfinite(*value))
        throw InputError(InputError::Kind::NotFinite, InputError::no_object, where,
                         fmt::format("must be a finite number, is {}", printable(word)));
    return *value;
}

double parse_radius(std::string_view word, std::size_t line_number) {
    const double radius = parse_number(word, line_number);
    if (radius < 0)
        throw InputError(InputError::Kind::NegativeRadius, InputError::no_object,
                         fmt::format("line {}", line_number),
                         fmt::format("a radius must be >= 0, is {}", printable(word)));
    return radius;
}

}  // namespace vcell
