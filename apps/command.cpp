#include "command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <new>
#include <optional>
#include <string_view>

#include "../core/platform.hpp"
#include "../io/files/files.hpp"
#include "../io/files/text.hpp"
#include "../io/pictures/mesh.hpp"
#include "../io/pictures/page.hpp"

namespace vcell {

void warn(const std::string& text) { fmt::print(stderr, "vcell: warning: {}\n", text); }

Status report_assumed(std::uint64_t assumed) {
    if (assumed == 0) return done;
    warn(fmt::format("{} coincidences could not be decided and were taken for granted", assumed));
    return undecided;
}

Failure failure_of_exception() {
    try {
        throw;
    } catch (const InputError& e) {
        return {bad_input, e.what()};
    } catch (const UndecidedError& e) {
        return {undecided, e.what()};
    } catch (const ReadError& e) {
        return {bad_input, e.what()};
    } catch (const TooManyTriangles& e) {
        return {wrong_usage, fmt::format("--triangles: {}", e.what())};
    } catch (const WriteError& e) {
        return {wrong_usage, e.what()};
    } catch (const UsageError& e) {
        return {wrong_usage, e.what()};
    } catch (const EnvironmentError& e) {
        return {wrong_usage, e.what()};
    } catch (const std::bad_alloc&) {
        return {undecided, "out of memory"};
    } catch (const std::exception& e) {
        return {undecided,
                fmt::format("internal error: {}\nThis is a fault of vcell, not of the input. Nothing was "
                            "written; please report it together with the scene.",
                            e.what())};
    }
}

void require_pages(const std::string& target) {
    if (!has_pages())
        throw UsageError(fmt::format(
            "{}: this program was built without three.js and writes no pages (Debian's package is libjs-three)",
            target == "-" ? "html" : target));
}

std::optional<Box> box_argument(const std::vector<double>& corners) {
    if (corners.empty()) return std::nullopt;
    for (std::size_t k = 0; k < 3; ++k)
        if (!(corners[k] < corners[k + 3]))
            throw UsageError(fmt::format("--box: {0}0 must be < {0}1 = {2}, is {1}", "XYZ"[k], corners[k],
                                         corners[k + 3]));
    return Box{{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
}

void warn_of_chord(const std::string& wanted, std::size_t most_triangles, std::size_t triangles,
                   const std::string& chord) {
    warn(fmt::format(
        "a chord of {} is too fine for {} triangles (--triangles) or 4096 pieces of an edge: the mesh has {} "
        "triangles with one of {}",
        wanted, most_triangles, triangles, chord));
}

std::vector<std::string> arguments(int argc, const char* const* argv) {
    std::vector<std::string> all;
    for (int i = argc - 1; i > 0; --i) {
        std::string& text = all.emplace_back(argv[i]);
        if (text.size() > 2 && text.starts_with("-.") && text[2] >= '0' && text[2] <= '9')
            text.insert(1, "0");
    }
    return all;
}

std::string number_complaint(const std::string& text) {
    const std::optional<double> value =
        to_double(std::string_view(text).substr(text.starts_with('+') ? 1 : 0));
    return value && std::isfinite(*value) ? ""
                                          : fmt::format("must be a finite number, is {}", printable(text));
}

std::string positive_complaint(const std::string& text) {
    const std::string complaint = number_complaint(text);
    if (!complaint.empty()) return complaint;
    return *to_double(std::string_view(text).substr(text.starts_with('+') ? 1 : 0)) > 0
               ? ""
               : fmt::format("must be > 0, is {}", printable(text));
}

std::string count_complaint(const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
    return digits && text.size() < 10 && std::stoul(text) > 0
               ? ""
               : fmt::format("must be a number from 1 to 999999999, is {}", printable(text));
}

std::optional<Chord> to_chord(std::string_view text) {
    const bool is_relative = text.ends_with('%');
    if (is_relative) text.remove_suffix(1);
    const std::optional<double> value = to_double(text);
    if (!value || !std::isfinite(*value) || !(*value > 0)) return std::nullopt;
    return Chord{is_relative ? *value / 100 : *value, is_relative};
}

std::string chord_complaint(const std::string& text) {
    return to_chord(text)
               ? ""
               : fmt::format("must be a length above 0 or a percentage of the cell's diagonal, is {}",
                             printable(text));
}

std::string part_complaint(const std::string& text) {
    const auto chord = to_chord(text);
    return chord && chord->is_relative ? "" : fmt::format("must be like 0.2%, is {}", printable(text));
}

}  // namespace vcell
