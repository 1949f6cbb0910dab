#include "json_writer.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <ostream>

#include "../../core/errors.hpp"

namespace vcell {

void JsonWriter::finish() {
    out_->write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
}

// What lines() have made elsewhere.
void JsonWriter::append(const std::string& text) {
    finish();
    out_->write(text.data(), static_cast<std::streamsize>(text.size()));
    first_ = false;
}

void JsonWriter::separate() {
    if (after_key_) {
        after_key_ = false;
        return;
    }
    if (!first_) buffer_ += ',';
    if (new_line_) buffer_ += '\n';
    first_ = new_line_ = false;
    constexpr std::size_t enough = 1 << 16;
    if (out_ != nullptr && buffer_.size() > enough) finish();
}

void JsonWriter::open(char bracket) {
    separate();
    buffer_ += bracket;
    first_ = true;
}

void JsonWriter::close(char bracket) {
    buffer_ += bracket;
    first_ = false;
}

JsonWriter& JsonWriter::key(std::string_view name) {
    separate();
    quoted(name);
    buffer_ += ':';
    after_key_ = true;
    return *this;
}

void JsonWriter::value(double v) {
    if (!std::isfinite(v)) throw InternalError("a number to be written is not finite");
    separate();
    fmt::format_to(std::back_inserter(buffer_), "{}", v);
}

void JsonWriter::value(std::uint64_t v) {
    separate();
    fmt::format_to(std::back_inserter(buffer_), "{}", v);
}

void JsonWriter::value(bool v) {
    separate();
    buffer_ += v ? "true" : "false";
}

void JsonWriter::value(std::string_view v) {
    separate();
    quoted(v);
}

void JsonWriter::null() {
    separate();
    buffer_ += "null";
}

void JsonWriter::quoted(std::string_view text) {
    buffer_ += '"';
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            buffer_ += '\\';
            buffer_ += c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            fmt::format_to(std::back_inserter(buffer_), "\\u{:04x}", static_cast<unsigned>(c));
        } else {
            buffer_ += c;
        }
    }
    buffer_ += '"';
}

}  // namespace vcell
