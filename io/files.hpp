/// Reading whole files, and writing them so that a target is either complete or untouched.
#pragma once

#include <fstream>
#include <iosfwd>
#include <stdexcept>
#include <string>

namespace vcell {

/// A file that cannot be read.
struct ReadError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// A file that cannot be written.
struct WriteError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The bytes of a file; of standard input for "-". Throws ReadError.
std::string read_file(const std::string& path);

/// An output that appears under its name only when it is complete: it is written to a temporary file
/// beside the target, and commit() renames that. Without commit() the temporary file goes with the
/// object, and with the process on SIGINT, SIGTERM and SIGHUP (see remove_unfinished_on_signals).
/// "-" is standard output and devices and pipes are written in place: there is nothing to rename.
class OutputFile {
public:
    /// Creates the temporary file, so a target that cannot be written is known before the work.
    /// Throws WriteError.
    explicit OutputFile(std::string target);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    const std::string& target() const { return target_; }
    std::ostream& stream();
    /// Ends writing: all bytes have reached the file. Throws WriteError. Several outputs are all
    /// closed before the first is committed.
    void close();
    /// Closes, and gives the file its name. Throws WriteError.
    void commit();

private:
    [[noreturn]] void fail(const std::string& what) const;

    std::string target_;     // as the user wrote it
    std::string final_;      // where it goes: symbolic links are followed
    std::string temporary_;  // empty: written in place, or renamed
    std::ofstream file_;
    bool closed_ = false;
};

/// Makes SIGINT, SIGTERM and SIGHUP remove the temporary files of all OutputFiles before they end the
/// process. For programs; a library leaves its host's signals alone.
void remove_unfinished_on_signals();

}  // namespace vcell
