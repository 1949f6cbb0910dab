/// Text as it meets the user: UTF-8, messages, numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace vcell {

/// The bytes of the UTF-8 character that `text` starts with; 0 if it starts with none.
std::size_t utf8_length(std::string_view text);

/// `text` fit for a one-line message: control characters and broken UTF-8 become '?', and what goes
/// beyond 40 bytes "...".
std::string printable(std::string_view text);

/// `text` as XML 1.0 holds it: markup escaped, and U+FFFD for control characters, broken UTF-8, U+FFFE and
/// U+FFFF.
std::string xml_escaped(std::string_view text);

/// `text` without the UTF-8 byte order mark that some editors put before it.
std::string_view without_byte_order_mark(std::string_view text);

/// The next line of `text` from `at` on, without its end and without what follows '#'; moves `at` behind
/// the line. Pre: at < text.size().
std::string_view next_line(std::string_view text, std::size_t& at);

/// The next word of a line, blank-separated, taken off its front; empty at the end of the line.
std::string_view next_word(std::string_view& line);

/// The double nearest to the number that a whole word spells, infinite beyond the range of double.
std::optional<double> to_double(std::string_view word);

/// The finite number that a word spells. Throws InputError "line <n>: ..." for anything else.
double parse_number(std::string_view word, std::size_t line_number);
/// The radius that a word spells: a finite number that is not negative. Throws as parse_number() does.
double parse_radius(std::string_view word, std::size_t line_number);

}  // namespace vcell
