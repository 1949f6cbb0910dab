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

/// An output that appears under its name only when it is complete. It is written to a file without any name
/// in the target's folder, which the system forgets with the process, however that ends; commit() gives it
/// its name. Only to replace an older file it has a hidden one for a moment, as the system renames but does
/// not link over an existing file. Where the file system has no nameless files it is hidden beside the target
/// until commit(), and goes with the object, and with the process on SIGINT, SIGTERM and SIGHUP (see
/// remove_unfinished_on_signals). "-" is standard output and devices and pipes are written in place.
class OutputFile {
public:
    enum class Unfinished { Nameless, Hidden };

    /// Creates the file, so a target that cannot be written is known before the work. Throws WriteError.
    explicit OutputFile(std::string target, Unfinished unfinished = Unfinished::Nameless);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    const std::string& target() const { return target_; }
    std::ostream& stream();
    /// Of Unfinished::Hidden: the file, for others to write to until close(). Empty for "-", devices and
    /// pipes.
    const std::string& hidden() const { return temporary_; }
    /// Ends writing: all bytes have reached the file. Throws WriteError. Several outputs are all
    /// closed before the first is committed.
    void close();
    /// Closes, and gives the file its name. Throws WriteError.
    void commit();

private:
    [[noreturn]] void fail(const std::string& what) const;
    std::string hidden_name(const std::string& ending) const;
    void open_nameless();
    void open_hidden();
    bool set_mode(int descriptor) const;
    void link_nameless();
    void discard();

    std::string target_;     // as the user wrote it
    std::string final_;      // where it goes: symbolic links are followed
    std::string temporary_;  // hidden; empty: there is none
    int nameless_ = -1;      // descriptor; -1: there is none
    std::ofstream file_;
    bool closed_ = false;
};

/// Makes SIGINT, SIGTERM and SIGHUP remove the hidden files of all OutputFiles before they end the
/// process. For programs; a library leaves its host's signals alone.
void remove_unfinished_on_signals();

}  // namespace vcell
