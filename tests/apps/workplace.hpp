/// The program from outside, run in a directory of its own.
#pragma once

#include <doctest/doctest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

inline std::string contents(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

struct Outcome {
    int status;
    std::string out, err;
};

/// A directory of its own, in which the program runs.
class Workplace {
public:
    Workplace() {
        std::string name = (fs::temp_directory_path() / "vcell_program_test.XXXXXX").string();
        REQUIRE(::mkdtemp(name.data()) != nullptr);
        dir_ = fs::path(name) / "work";
        fs::create_directory(dir_);
    }
    ~Workplace() { fs::remove_all(dir_.parent_path()); }

    /// `arguments` as a shell reads them. The streams are kept outside the directory.
    Outcome run(const std::string& arguments, const std::string& input = "") const {
        return run_command("'" VCELL_PROGRAM "' " + arguments, input);
    }
    /// Any program.
    Outcome run_command(const std::string& program, const std::string& input = "") const {
        const fs::path outside = dir_.parent_path();
        std::ofstream(outside / "in", std::ios::binary) << input;
        const std::string command =
            "cd '" + dir_.string() + "' && " + program + " < ../in > ../out 2> ../err";
        const int status = std::system(command.c_str());
        REQUIRE(WIFEXITED(status));
        return {WEXITSTATUS(status), contents(outside / "out"), contents(outside / "err")};
    }

    void write(const char* name, const std::string& text) const {
        std::ofstream(dir_ / name, std::ios::binary) << text;
    }
    std::string read(const char* name) const { return contents(dir_ / name); }
    fs::path path(const char* name) const { return dir_ / name; }
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(dir_)) names.push_back(entry.path().filename());
        std::sort(names.begin(), names.end());
        return names;
    }

private:
    fs::path dir_;
};

inline std::string example(const std::string& name) { return VCELL_EXAMPLE_SCENES "/" + name; }
