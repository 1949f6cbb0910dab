/// What the program may be told about files of balls.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "../io/files/ball_file.hpp"

namespace vcell {

class BallFileArguments {
public:
    void add_to(CLI::App& command, const char* group);
    /// For commands that have groups.
    void add_groups_to(CLI::App& command, const char* group);
    /// Pre: the command line was parsed.
    BallFileOptions options() const;

private:
    std::string frame_, group_;
    std::vector<std::string> radii_;
    bool has_hydrogens_ = false, leaves_water_ = false, leaves_hetero_ = false;
};

}  // namespace vcell
