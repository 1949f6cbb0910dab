/// vcell diagram: the cells of all objects.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ball_file_arguments.hpp"
#include "command.hpp"
#include "threads_argument.hpp"

namespace vcell {

class DiagramCommand {
public:
    explicit DiagramCommand(CLI::App& app);

    bool chosen() const { return command_.parsed(); }
    Status run() const;

private:
    CLI::App& command_;
    std::string path_, cells_, contacts_, groups_, network_, periodic_, cut_;
    std::vector<std::string> outputs_;
    std::vector<double> box_, tilt_;
    std::optional<double> probe_;
    BallFileArguments files_;
    ThreadsArgument threads_;
};

}  // namespace vcell
