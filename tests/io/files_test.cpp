#include "../../io/files/files.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "temporary_directory.hpp"

using namespace vcell;
namespace fs = std::filesystem;
using testing::TemporaryDirectory;

namespace {

constexpr OutputFile::Unfinished both[] = {OutputFile::Unfinished::Nameless, OutputFile::Unfinished::Hidden};

}  // namespace

TEST_CASE("output file: appears complete, on commit only") {
    for (const auto unfinished : both) {
        TemporaryDirectory dir;
        OutputFile out(dir.file("a.json"), unfinished);
        out.stream() << "text";
        CHECK_FALSE(fs::exists(dir.file("a.json")));
        out.commit();
        CHECK(read_file(dir.file("a.json")) == "text");
        CHECK(dir.count() == 1);
    }
}

TEST_CASE("output file: without commit nothing remains and the old content stays") {
    for (const auto unfinished : both) {
        TemporaryDirectory dir;
        std::ofstream(dir.file("a.json")) << "old";
        {
            OutputFile out(dir.file("a.json"), unfinished);
            out.stream() << "new";
            out.close();
            CHECK(dir.count() == (unfinished == OutputFile::Unfinished::Hidden ? 2 : 1));
        }
        CHECK(read_file(dir.file("a.json")) == "old");
        CHECK(dir.count() == 1);
    }
}

TEST_CASE("output file: keeps an old file's mode, follows links") {
    for (const auto unfinished : both) {
        TemporaryDirectory dir;
        std::ofstream(dir.file("real")) << "old";
        REQUIRE(::chmod(dir.file("real").c_str(), 0640) == 0);
        fs::create_symlink("real", dir.file("link"));
        OutputFile out(dir.file("link"), unfinished);
        out.stream() << "new";
        out.commit();
        CHECK(fs::is_symlink(dir.file("link")));
        CHECK(read_file(dir.file("real")) == "new");
        CHECK((fs::status(dir.file("real")).permissions() & fs::perms::mask) == fs::perms(0640));
        CHECK(dir.count() == 2);
    }
}

TEST_CASE("output file: a file that appears meanwhile is replaced, whatever hidden names are taken") {
    TemporaryDirectory dir;
    OutputFile out(dir.file("a"));
    out.stream() << "new";
    std::ofstream(dir.file("a")) << "of another program";
    const std::string left_over = dir.file((".a." + std::to_string(::getpid()) + ".0").c_str());
    std::ofstream(left_over) << "left over";
    out.commit();
    CHECK(read_file(dir.file("a")) == "new");
    CHECK(read_file(left_over) == "left over");
    CHECK(dir.count() == 2);
}

TEST_CASE("output file: a new file has the mode that the mask leaves") {
    for (const auto unfinished : both) {
        TemporaryDirectory dir;
        const mode_t mask = ::umask(0027);
        OutputFile out(dir.file("a"), unfinished);
        out.commit();
        ::umask(mask);
        CHECK((fs::status(dir.file("a")).permissions() & fs::perms::mask) == fs::perms(0640));
    }
}

TEST_CASE("output file: what cannot be written is known at once") {
    TemporaryDirectory dir;
    CHECK_THROWS_AS(OutputFile("/nowhere/a.json"), WriteError);
    CHECK_THROWS_AS(OutputFile(dir.file("")), WriteError);
    CHECK_THROWS_AS(OutputFile(""), WriteError);
    CHECK(dir.count() == 0);
}

TEST_CASE("output file: devices are written in place, and a full one is an error") {
    {
        OutputFile out("/dev/null");
        out.stream() << "gone";
        out.commit();
    }
    CHECK(fs::is_character_file("/dev/null"));
    if (!fs::is_character_file("/dev/full")) return;
    OutputFile out("/dev/full");
    out.stream() << "no room";
    CHECK_THROWS_AS(out.commit(), WriteError);
}

TEST_CASE("output file: a signal leaves nothing behind") {
    // No handler hears SIGKILL: only a nameless file goes with its process.
    for (const auto& [unfinished, signal] : {std::pair(OutputFile::Unfinished::Nameless, SIGKILL),
                                             std::pair(OutputFile::Unfinished::Nameless, SIGTERM),
                                             std::pair(OutputFile::Unfinished::Hidden, SIGTERM)}) {
        TemporaryDirectory dir;
        const pid_t child = ::fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            for (const int s : {SIGINT, SIGTERM, SIGHUP}) ::signal(s, SIG_DFL);
            remove_unfinished_on_signals();
            OutputFile out(dir.file("a.json"), unfinished);
            out.stream() << "half" << std::flush;
            ::raise(signal);
            ::_exit(0);
        }
        int status = 0;
        REQUIRE(::waitpid(child, &status, 0) == child);
        CHECK(WIFSIGNALED(status));
        CHECK(WTERMSIG(status) == signal);
        CHECK(dir.count() == 0);
    }
}

TEST_CASE("read_file: any bytes") {
    TemporaryDirectory dir;
    std::string bytes;
    for (int i = 0; i < 200'000; ++i) bytes += static_cast<char>(i * 7);
    std::ofstream(dir.file("b"), std::ios::binary) << bytes;
    CHECK(read_file(dir.file("b")) == bytes);
    CHECK_THROWS_AS(read_file(dir.file("missing")), ReadError);
    CHECK_THROWS_AS(read_file(dir.file("")), ReadError);
}
