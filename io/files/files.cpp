#include "files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <system_error>

namespace vcell {

namespace {

// What a signal handler may touch: no lock, no allocation. A slot holds a file name or nothing.
constexpr std::size_t slot_count = 64;
std::array<std::atomic<char*>, slot_count> unfinished{};
static_assert(std::atomic<char*>::is_always_lock_free);

void remember(const std::string& path) {
    char* const copy = ::strdup(path.c_str());
    for (auto& slot : unfinished) {
        char* empty = nullptr;
        if (slot.compare_exchange_strong(empty, copy)) return;
    }
    std::free(copy);  // more outputs than slots: only a signal would leave this one behind
}

void forget(const std::string& path) {
    for (auto& slot : unfinished) {
        char* const name = slot.load();
        if (name && path == name) {
            slot.store(nullptr);
            std::free(name);
            return;
        }
    }
}

extern "C" void on_signal(int signal) {
    for (auto& slot : unfinished)
        if (const char* const name = slot.load()) ::unlink(name);
    ::raise(signal);  // SA_RESETHAND: this time it ends the process
}

std::string last_error() { return std::strerror(errno); }

std::string path_of(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

}  // namespace

std::string read_file(const std::string& path) {
    const auto read_all = [&](std::istream& in) {
        std::string bytes;
        std::array<char, 1 << 16> block;
        while (in.read(block.data(), block.size()) || in.gcount() > 0)
            bytes.append(block.data(), static_cast<std::size_t>(in.gcount()));
        if (in.bad() || !in.eof()) throw ReadError(fmt::format("cannot read {}: {}", path, last_error()));
        return bytes;
    };
    if (path == "-") return read_all(std::cin);
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        throw ReadError(fmt::format("cannot read {}: it is a directory", path));
    std::ifstream file(path, std::ios::binary);
    if (!file) throw ReadError(fmt::format("cannot read {}: {}", path, last_error()));
    return read_all(file);
}

OutputFile::OutputFile(std::string target, Unfinished unfinished)
    : target_(std::move(target)), final_(target_) {
    namespace fs = std::filesystem;
    if (target_ == "-") return;
    if (target_.empty()) throw WriteError("cannot write a file without a name");
    std::error_code error;
    const fs::file_status status = fs::status(target_, error);
    if (fs::is_directory(status)) fail("it is a directory");
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        file_.open(target_, std::ios::binary);
        if (!file_) fail(last_error());
        return;
    }
    if (fs::exists(status)) {
        // Renaming would go round a file's write protection.
        if (::access(target_.c_str(), W_OK) != 0) fail(last_error());
        final_ = fs::canonical(target_, error).string();
        if (error) fail(error.message());
    }
    if (fs::path(final_).filename().empty()) fail("it is a directory");
    if (unfinished == Unfinished::Nameless) open_nameless();
    if (nameless_ < 0) open_hidden();
}

std::string OutputFile::hidden_name(const std::string& ending) const {
    const std::filesystem::path final_path(final_);
    return (final_path.parent_path() / fmt::format(".{}.{}", final_path.filename().string(), ending))
        .string();
}

// The target shall look as if it had been opened for writing: like the file that it replaces, or as the mask
// says.
bool OutputFile::set_mode(int descriptor) const {
    struct stat old;
    const mode_t mask = ::umask(0);
    ::umask(mask);
    const mode_t mode = ::stat(final_.c_str(), &old) == 0 ? old.st_mode & 07777 : 0666 & ~mask;
    return ::fchmod(descriptor, mode) == 0;
}

// Leaves nameless_ -1 where there are no such files, or no /proc to name one by.
void OutputFile::open_nameless() {
    const std::string folder = std::filesystem::path(final_).parent_path().string();
    nameless_ = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    if (nameless_ < 0) return;
    file_.open(path_of(nameless_), std::ios::binary);
    if (file_ && set_mode(nameless_)) return;
    discard();
    file_ = std::ofstream();
}

void OutputFile::open_hidden() {
    std::string name = hidden_name("XXXXXX");
    const int descriptor = ::mkstemp(name.data());
    if (descriptor < 0) fail(last_error());
    temporary_ = name;
    remember(temporary_);
    const bool ready = set_mode(descriptor);
    ::close(descriptor);
    file_.open(temporary_, std::ios::binary);
    if (!ready || !file_) {
        const std::string why = last_error();
        discard();
        fail(why);
    }
}

// To its target, if there is none yet; otherwise to a hidden name, in temporary_.
void OutputFile::link_nameless() {
    const std::string path = path_of(nameless_);
    const auto link_to = [&](const std::string& name) {
        return ::linkat(AT_FDCWD, path.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    };
    if (!link_to(final_)) {
        constexpr int attempts = 1000;  // the names of other processes that were killed at this very place
        for (int i = 0; errno == EEXIST && temporary_.empty() && i < attempts; ++i) {
            const std::string name = hidden_name(fmt::format("{}.{}", ::getpid(), i));
            remember(name);
            if (link_to(name)) {
                temporary_ = name;
            } else {
                const int why = errno;
                forget(name);
                errno = why;
            }
        }
        if (temporary_.empty()) fail(last_error());
    }
    ::close(nameless_);
    nameless_ = -1;
}

void OutputFile::discard() {
    file_.close();
    if (nameless_ >= 0) ::close(nameless_);
    nameless_ = -1;
    if (temporary_.empty()) return;
    ::unlink(temporary_.c_str());
    forget(temporary_);
    temporary_.clear();
}

OutputFile::~OutputFile() { discard(); }

std::ostream& OutputFile::stream() {
    if (target_ == "-") return std::cout;
    return file_;
}

void OutputFile::close() {
    if (closed_) return;
    errno = 0;
    std::ostream& out = stream();
    out.flush();
    if (file_.is_open()) file_.close();
    if (!out) fail(errno ? last_error() : "the bytes could not be stored");
    closed_ = true;
}

void OutputFile::commit() {
    close();
    if (nameless_ >= 0) link_nameless();
    if (temporary_.empty()) return;
    if (::rename(temporary_.c_str(), final_.c_str()) != 0) fail(last_error());
    forget(temporary_);
    temporary_.clear();
}

void OutputFile::fail(const std::string& what) const {
    throw WriteError(fmt::format("cannot write {}: {}", target_ == "-" ? "standard output" : target_, what));
}

void remove_unfinished_on_signals() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction action {};
        action.sa_handler = on_signal;
        action.sa_flags = SA_RESETHAND;
        struct sigaction old;
        // nohup and shells that ignore a signal for their children are obeyed.
        if (::sigaction(signal, nullptr, &old) == 0 && old.sa_handler == SIG_IGN) continue;
        ::sigaction(signal, &action, nullptr);
    }
}

}  // namespace vcell
