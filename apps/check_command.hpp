/// vcell check: is a file of a cell, or of a diagram, what it says?
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "../io/check/check.hpp"
#include "command.hpp"
#include "threads_argument.hpp"

namespace vcell {

class CheckCommand {
public:
    explicit CheckCommand(CLI::App& app);

    bool chosen() const { return command_.parsed(); }
    Status run() const;

private:
    CLI::App& command_;
    std::string path_;
    CheckOptions options_;
    ThreadsArgument threads_;
    bool json_ = false;
};

}  // namespace vcell
