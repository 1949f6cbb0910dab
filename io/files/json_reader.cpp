#include "json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "text.hpp"

namespace vcell {

JsonReader::JsonReader(std::string_view text) : text_(without_byte_order_mark(text)) {}

char JsonReader::peek() {
    while (at_ < text_.size()) {
        const char c = text_[at_];
        if (c != ' ' && c != '\n' && c != '\r' && c != '\t') return c;
        ++at_;
    }
    return '\0';
}

void JsonReader::open(char bracket, const char* what) {
    if (peek() != bracket) fail_type(what);
    ++at_;
}

bool JsonReader::next_in(char closing, bool first) {
    const char c = peek();
    if (c == closing) {
        ++at_;
        return false;
    }
    if (first) return true;
    if (c != ',') fail_syntax(fmt::format("expected ',' or '{}'", closing));
    ++at_;
    return true;
}

std::string_view JsonReader::read_key() {
    if (peek() != '"') fail_syntax("expected a key in double quotes");
    const std::string_view key = read_string();
    if (peek() != ':') fail_syntax("expected ':' after a key");
    ++at_;
    return key;
}

void JsonReader::enter(std::string_view key, bool repeated) {
    path_.push_back({key, 0});
    if (repeated) fail(InputError::Kind::Syntax, "given twice");
}

double JsonReader::number() {
    const std::string_view token = number_token();
    const double value = *to_double(token);  // the grammar of JSON is part of to_double's
    if (!std::isfinite(value))
        fail(InputError::Kind::NotFinite,
             fmt::format("must be a finite number, {} is out of range", printable(token)));
    return value;
}

std::uint64_t JsonReader::unsigned_integer(std::uint64_t limit) {
    const std::string_view token = number_token();
    std::uint64_t value = 0;
    const auto [end, ec] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (ec == std::errc::invalid_argument || (ec == std::errc() && end != token.data() + token.size()))
        fail(InputError::Kind::WrongType,
             fmt::format("must be a non-negative integer, is {}", printable(token)));
    if (ec != std::errc() || value > limit)
        fail(InputError::Kind::OutOfRange, fmt::format("must be at most {}, is {}", limit, printable(token)));
    return value;
}

bool JsonReader::boolean() {
    const char c = peek();
    if (c != 't' && c != 'f') fail_type("true or false");
    literal(c == 't' ? "true" : "false");
    return c == 't';
}

std::string JsonReader::string() {
    if (peek() != '"') fail_type("a string");
    return std::string(read_string());
}

bool JsonReader::null() {
    if (peek() != 'n') return false;
    literal("null");
    return true;
}

void JsonReader::end() {
    if (peek() != '\0' || at_ < text_.size()) fail_syntax("expected the end of the text");
}

void JsonReader::literal(std::string_view word) {
    if (!text_.substr(at_).starts_with(word)) fail_syntax(fmt::format("expected {}", word));
    at_ += word.size();
}

// number = [-] int [frac] [exp]; from_chars alone would also take "inf", "1." and "01".
std::string_view JsonReader::number_token() {
    if (!next_is_number()) {
        const std::string_view rest = text_.substr(at_);
        if (rest.starts_with("NaN") || rest.starts_with("Infinity"))
            fail(InputError::Kind::NotFinite, "must be a finite number");
        fail_type("a number");
    }
    const std::size_t begin = at_;
    const auto is_digit = [&] { return at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; };
    const auto take = [&](std::string_view any_of) {
        const bool found = at_ < text_.size() && any_of.find(text_[at_]) != any_of.npos;
        at_ += found;
        return found;
    };
    const auto digits = [&] {
        if (!is_digit()) fail_syntax("expected a digit");
        while (is_digit()) ++at_;
    };
    if (take("-") && text_.substr(at_).starts_with("Infinity"))
        fail(InputError::Kind::NotFinite, "must be a finite number");
    if (!take("0")) digits();
    if (is_digit()) fail_syntax("a number must not start with 0");
    if (take(".")) digits();
    if (take("eE")) {
        take("+-");
        digits();
    }
    return text_.substr(begin, at_ - begin);
}

// The string's characters, valid until the next string is read. Plain strings are not copied.
std::string_view JsonReader::read_string() {
    const std::size_t begin = ++at_;
    bool copied = false;
    std::size_t plain = begin;  // start of the stretch that is not in scratch_ yet
    for (;;) {
        if (at_ == text_.size()) fail_syntax("a string has no end");
        const unsigned char c = static_cast<unsigned char>(text_[at_]);
        if (c == '"') break;
        if (c < 0x20) fail_syntax("control character in a string");
        if (c == '\\') {
            if (!copied) scratch_.clear();
            copied = true;
            scratch_.append(text_, plain, at_ - plain);
            ++at_;
            read_escape();
            plain = at_;
        } else if (c < 0x80) {
            ++at_;
        } else {
            const std::size_t length = utf8_length(text_.substr(at_));
            if (length == 0) fail_syntax("not UTF-8");
            at_ += length;
        }
    }
    const std::string_view tail = text_.substr(plain, at_ - plain);
    ++at_;
    if (!copied) return tail;
    scratch_.append(tail);
    return scratch_;
}

// Pre: at_ is behind the backslash.
void JsonReader::read_escape() {
    if (at_ == text_.size()) fail_syntax("a string has no end");
    constexpr std::string_view letters = "\"\\/bfnrt", meanings = "\"\\/\b\f\n\r\t";
    const char c = text_[at_++];
    if (const std::size_t i = letters.find(c); i != letters.npos) {
        scratch_ += meanings[i];
        return;
    }
    if (c != 'u') fail_syntax("unknown escape in a string");
    unsigned code = read_hex4();
    if (code >= 0xDC00 && code < 0xE000) fail_syntax("half a surrogate pair");
    if (code >= 0xD800 && code < 0xDC00) {
        if (!text_.substr(at_).starts_with("\\u")) fail_syntax("half a surrogate pair");
        at_ += 2;
        const unsigned low = read_hex4();
        if (low < 0xDC00 || low >= 0xE000) fail_syntax("half a surrogate pair");
        code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
    }
    append_utf8(code);
}

unsigned JsonReader::read_hex4() {
    unsigned value = 0;
    const std::string_view digits = text_.substr(at_, 4);
    const auto [end, ec] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (digits.size() != 4 || ec != std::errc() || end != digits.data() + 4)
        fail_syntax("expected four hexadecimal digits");
    at_ += 4;
    return value;
}

void JsonReader::append_utf8(unsigned c) {
    const auto tail = [&](int shift) { scratch_ += static_cast<char>(0x80 | ((c >> shift) & 0x3F)); };
    if (c < 0x80) {
        scratch_ += static_cast<char>(c);
    } else if (c < 0x800) {
        scratch_ += static_cast<char>(0xC0 | (c >> 6));
        tail(0);
    } else if (c < 0x10000) {
        scratch_ += static_cast<char>(0xE0 | (c >> 12));
        tail(6), tail(0);
    } else {
        scratch_ += static_cast<char>(0xF0 | (c >> 18));
        tail(12), tail(6), tail(0);
    }
}

std::string JsonReader::path() const {
    std::string result;
    for (const Segment& s : path_) {
        if (s.key.empty()) {
            result += fmt::format("[{}]", s.index);
        } else {
            if (!result.empty()) result += '.';
            result += s.key;
        }
    }
    return result;
}

void JsonReader::fail(InputError::Kind kind, const std::string& what) const {
    throw InputError(kind, object_index, path(), what);
}

void JsonReader::fail_unknown(std::string_view key, std::initializer_list<std::string_view> known) {
    // The path names a key that no schema holds: it lives as long as this function.
    const std::string name = printable(key);
    path_.push_back({name.empty() ? std::string_view("\"\"") : std::string_view(name), 0});
    fail(InputError::Kind::UnknownKey, fmt::format("unknown key, known are {}", fmt::join(known, ", ")));
}

void JsonReader::fail_missing(std::string_view key) {
    path_.push_back({key, 0});
    fail(InputError::Kind::MissingKey, "missing");
}

void JsonReader::fail_length(std::size_t count) {
    // Met at the element that is one too many: the complaint is about the array.
    if (path_.back().key.empty() && path_.back().index == count) path_.pop_back();
    fail(InputError::Kind::WrongType, fmt::format("must have {} elements", count));
}

void JsonReader::fail_type(const char* expected) {
    const char c = peek();
    const char* found = nullptr;
    if (c == '{') found = "an object";
    if (c == '[') found = "an array";
    if (c == '"') found = "a string";
    if (next_is_number()) found = "a number";
    const std::string_view rest = text_.substr(at_);
    for (const char* word : {"true", "false", "null"})
        if (rest.starts_with(word)) found = word;
    if (!found) fail_syntax(fmt::format("expected {}", expected));
    fail(InputError::Kind::WrongType, fmt::format("must be {}, is {}", expected, found));
}

void JsonReader::fail_syntax(const std::string& what) const {
    const std::string_view before = text_.substr(0, at_);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::string_view in_line = before.substr(before.rfind('\n') + 1);  // npos + 1 == 0
    const auto column =
        1 + std::count_if(in_line.begin(), in_line.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; });
    const std::string found = at_ < text_.size() ? fmt::format("found '{}'", printable(text_.substr(at_, 8)))
                                                 : std::string("the text ends");
    fail(InputError::Kind::Syntax, fmt::format("line {}, column {}: {}, {}", line, column, what, found));
}

}  // namespace vcell
