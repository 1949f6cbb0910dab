/// Strict JSON [RFC 8259] read as a stream, straight into the structures it describes.
///
/// The caller says what it expects next, so a document is never held as a tree, its nesting is bounded
/// by the caller's own, and the first thing that does not fit is reported with its path. Unknown, missing
/// and repeated keys are errors; so are NaN, Infinity and numbers beyond the range of double.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "../../core/errors.hpp"

namespace vcell {

/// One member that an object may have: its key, whether it must be there, and what reads its value.
template <class F>
struct JsonMember {
    std::string_view key;
    bool required;
    F read;
};
template <class F>
JsonMember<F> required_member(std::string_view key, F read) {
    return {key, true, read};
}
template <class F>
JsonMember<F> optional_member(std::string_view key, F read) {
    return {key, false, read};
}

/// Every function reads the next value or throws InputError with its path, as "objects[3].sphere.radius".
/// Syntax errors name line and column too.
class JsonReader {
public:
    /// `text` must outlive the reader. A leading UTF-8 byte order mark is skipped.
    explicit JsonReader(std::string_view text);

    /// An object with these members and no others, each at most once, in any order.
    template <class... F>
    void object(JsonMember<F>... members) {
        static_assert(sizeof...(F) <= 32);
        open('{', "an object");
        std::uint32_t seen = 0;
        for (bool first = true; next_in('}', first); first = false) {
            const std::string_view key = read_key();
            std::uint32_t bit = 1;
            const bool known = (... || (key == members.key ? (enter(members.key, seen & bit), seen |= bit,
                                                              members.read(), leave(), true)
                                                           : (bit <<= 1, false)));
            if (!known) fail_unknown(key, {members.key...});
        }
        std::uint32_t bit = 1;
        ((members.required && !(seen & bit) ? fail_missing(members.key) : void(), bit <<= 1), ...);
    }

    /// An array of any length; `element` is called with the index and reads one value.
    template <class F>
    void array(F element) {
        open('[', "an array");
        std::size_t i = 0;
        for (; next_in(']', i == 0); ++i) {
            path_.push_back({{}, i});
            element(i);
            leave();
        }
    }

    /// An array of exactly `count` elements; `element` is called with 0 ... count - 1.
    template <class F>
    void array_of(std::size_t count, F element) {
        std::size_t n = 0;
        array([&](std::size_t i) {
            if (i == count) fail_length(count);
            element(i);
            n = i + 1;
        });
        if (n != count) fail_length(count);
    }

    double number();
    /// An integer in [0, limit].
    std::uint64_t unsigned_integer(std::uint64_t limit = UINT64_MAX);
    bool boolean();
    std::string string();
    /// Consumes `null` if that is the next value.
    bool null();
    bool next_is_string() { return peek() == '"'; }
    bool next_is_number() { return peek() == '-' || (peek() >= '0' && peek() <= '9'); }

    /// Nothing but white space may follow.
    void end();

    /// Throws with the path of the value being read.
    [[noreturn]] void fail(InputError::Kind kind, const std::string& what) const;
    [[noreturn]] void fail_missing(std::string_view key);

    /// The scene object that errors are about, InputError::no_object for none.
    std::uint32_t object_index = InputError::no_object;

private:
    struct Segment {
        std::string_view key;  // empty: an array index
        std::size_t index;
    };

    char peek();  // the next character after white space, '\0' at the end
    void open(char bracket, const char* what);
    bool next_in(char closing, bool first);  // true: another member or element follows
    std::string_view read_key();
    void enter(std::string_view key, bool repeated);
    void leave() { path_.pop_back(); }
    void literal(std::string_view word);
    std::string_view read_string();
    void read_escape();
    unsigned read_hex4();
    void append_utf8(unsigned code_point);
    std::string_view number_token();
    std::string path() const;
    [[noreturn]] void fail_unknown(std::string_view key, std::initializer_list<std::string_view> known);
    [[noreturn]] void fail_length(std::size_t count);
    [[noreturn]] void fail_type(const char* expected);
    [[noreturn]] void fail_syntax(const std::string& what) const;

    std::string_view text_;
    std::size_t at_ = 0;
    std::vector<Segment> path_;
    std::string scratch_;  // a string with its escapes resolved
};

}  // namespace vcell
