/// JSON written as a stream: a cell of a million faces needs no second copy of itself.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <ranges>
#include <string>
#include <string_view>

#include "../../core/threads.hpp"

namespace vcell {

/// Values are appended in order; commas are the writer's business. Numbers are written with the fewest
/// digits (17 at most) that read back to the same double. Throws InternalError for a number that is not
/// finite: JSON has no word for it, and no result of ours may hold one.
class JsonWriter {
public:
    explicit JsonWriter(std::ostream& out) : out_(&out) {}
    /// Writes what is still buffered.
    void finish();

    /// object() and array() in parts.
    void begin_object() { open('{'); }
    void end_object() { close('}'); }
    void begin_array() { open('['); }
    void end_array() { close(']'); }
    template <class F>
    void object(F members) {
        open('{');
        members();
        close('}');
    }
    template <class F>
    void array(F elements) {
        open('[');
        elements();
        close(']');
    }
    /// An array with one element a line; `element` writes one of them.
    template <class Range, class F>
    void lines(const Range& range, F element) {
        open('[');
        for (const auto& e : range) {
            new_line_ = true;
            element(e);
        }
        if (!first_) buffer_ += '\n';
        close(']');
    }
    /// lines() by several threads, which make the text in parts that wait to be written in their order.
    /// element(writer, e) writes to the writer it is given.
    template <class Elements, class F>
    void lines(const Elements& elements, unsigned threads, const F& element) {
        open('[');
        in_order(
            range_count(elements.size()), thread_count(threads),
            [&](std::size_t task) {
                JsonWriter part;
                part.first_ = task == 0;
                const std::size_t begin = task * elements_of_task,
                                  end = std::min(elements.size(), begin + elements_of_task);
                for (std::size_t i = begin; i < end; ++i) {
                    part.new_line_ = true;
                    element(part, elements[i]);
                }
                return std::move(part.buffer_);
            },
            [&](std::size_t, const std::string& text) { append(text); });
        if (!first_) buffer_ += '\n';
        close(']');
    }
    JsonWriter& key(std::string_view name);
    /// A key on a new line.
    JsonWriter& line_key(std::string_view name) {
        new_line_ = true;
        return key(name);
    }

    void value(double v);
    void value(std::uint64_t v);
    void value(std::uint32_t v) { value(std::uint64_t{v}); }
    void value(int v) { value(static_cast<std::uint64_t>(v)); }  ///< Pre: v >= 0
    void value(bool v);
    void value(std::string_view v);
    void value(const char* v) { value(std::string_view(v)); }
    void null();
    template <int N>
    void value(const Eigen::Matrix<double, N, 1>& v) {
        array([&] {
            for (const double x : v) value(x);
        });
    }
    template <std::ranges::input_range Values>
    requires(!std::convertible_to<const Values&, std::string_view>) void value(const Values& values) {
        array([&] {
            for (const auto& v : values) value(v);
        });
    }

private:
    JsonWriter() = default;  // of a part, which stays in the buffer

    void append(const std::string& text);
    void open(char bracket);
    void close(char bracket);
    void separate();
    void quoted(std::string_view text);

    std::ostream* out_ = nullptr;
    std::string buffer_;
    bool first_ = true;  // nothing precedes the next value in its array or object
    bool after_key_ = false;
    bool new_line_ = false;
};

}  // namespace vcell
