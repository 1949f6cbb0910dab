/// What readers of lines share: lines with their numbers, complaints about them, radii.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "../../core/errors.hpp"
#include "ball_file.hpp"
#include "element_radii.hpp"
#include "text.hpp"

namespace vcell {

[[noreturn]] inline void fail_line(std::size_t line, const std::string& what,
                                   InputError::Kind kind = InputError::Kind::Syntax) {
    throw InputError(kind, InputError::no_object, fmt::format("line {}", line), what);
}

/// The lines of a text, without their ends. ('#' begins no comment in these formats.)
class Lines {
public:
    explicit Lines(std::string_view text) : text_(text) {}

    bool at_end() const { return at_ >= text_.size(); }
    /// The number of the line that next() gave last, from 1.
    std::size_t number() const { return number_; }
    /// Pre: !at_end().
    std::string_view next() {
        const std::size_t end = std::min(text_.find('\n', at_), text_.size());
        std::string_view line = text_.substr(at_, end - at_);
        at_ = std::min(end + 1, text_.size());
        ++number_;
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }
    /// The next line; throws InputError where there is none: "<what> is missing".
    std::string_view expect(std::string_view what) {
        if (at_end()) fail_line(number_ + 1, fmt::format("{} is missing", what));
        return next();
    }

private:
    std::string_view text_;
    std::size_t at_ = 0, number_ = 0;
};

inline std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::string_view word; !(word = next_word(line)).empty();) words.push_back(word);
    return words;
}

/// The radius of an element, a species or a type. Throws InputError where there is none.
inline double radius_of(std::string_view kind, const BallFileOptions& options, std::size_t line) {
    if (const auto given = options.radii.find(std::string(kind)); given != options.radii.end())
        return given->second;
    const std::optional<double> known = element_radius(kind);
    if (!known)
        fail_line(line, fmt::format("there is no radius of '{}' in the table; --radius {}=R gives one",
                                    printable(kind), printable(kind)));
    return *known;
}

/// A whole number that is not negative; `what` says what it counts, in a complaint.
inline std::size_t parse_count(std::string_view word, std::size_t line,
                               std::string_view what = "a number of atoms") {
    std::size_t value = 0;
    const bool is_number =
        !word.empty() && word.size() < 16 && word.find_first_not_of("0123456789") == std::string_view::npos;
    if (!is_number) fail_line(line, fmt::format("must be {}, is '{}'", what, printable(word)));
    for (const char digit : word) value = 10 * value + static_cast<std::size_t>(digit - '0');
    return value;
}

[[noreturn]] inline void fail_frame(std::size_t frames, std::size_t wanted) {
    throw InputError(InputError::Kind::OutOfRange, InputError::no_object, "--frame",
                     fmt::format("must be less than the number of frames, {}, is {}", frames, wanted));
}

}  // namespace vcell
