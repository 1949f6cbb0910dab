/// What the commands of the program share.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "../core/errors.hpp"
#include "../primitives/objects/scene.hpp"

namespace vcell {

/// The program's exit status.
enum Status { done = 0, wrong_usage = 1, bad_input = 2, undecided = 3, check_failed = 4 };

void warn(const std::string& text);

/// Wrong usage that the option parser cannot see.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// What ends a run: its status, and what standard error says.
struct Failure {
    Status status;
    std::string text;
};
/// Returns what the program says of the exception that is being handled, and its exit status.
Failure failure_of_exception();

/// Throws UsageError where the program was built without what pages are made of.
void require_pages(const std::string& target);

/// f(), whose complaints about a file's contents name the file: `name` instead of standard input.
template <class F>
auto about_file(const std::string& path, const char* name, F f) {
    const auto named = [&](const char* what) {
        const std::string file = path == "-" ? name : path;
        return file.empty() ? what : file + ": " + what;
    };
    try {
        return f();
    } catch (const InputError& e) {
        if (e.path.starts_with("--")) throw;  // about an option
        throw InputError(e.kind, e.object, "", named(e.what()));
    } catch (const UndecidedError& e) {
        throw UndecidedError(named(e.what()));
    }
}

/// Whether every question was decided; a warning where coincidences were taken for granted.
Status report_assumed(std::uint64_t assumed);

/// The box of a --box; none where that is not given. Throws UsageError where it has no inside.
std::optional<Box> box_argument(const std::vector<double>& corners);

/// A length, or in percent of the cell's diagonal: "0.01", "0.1%".
struct Chord {
    double value = 0;
    bool is_relative = false;
};
std::optional<Chord> to_chord(std::string_view text);

/// Warns where a mesh has a larger chord than was asked for; both as the user writes them.
void warn_of_chord(const std::string& wanted, std::size_t most_triangles, std::size_t triangles,
                   const std::string& chord);

/// A program's arguments as the option parser takes them, the last one first. It would take -.5 for an
/// option: it gets -0.5.
std::vector<std::string> arguments(int argc, const char* const* argv);

// The option parser asks these before it converts: an empty answer is consent.
std::string number_complaint(const std::string& text);
std::string positive_complaint(const std::string& text);
std::string count_complaint(const std::string& text);
std::string chord_complaint(const std::string& text);
std::string part_complaint(const std::string& text);

}  // namespace vcell
