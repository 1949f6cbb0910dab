/// vcell diagram: the cells of all objects.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "chord_argument.hpp"
#include "command.hpp"
#include "diagram_scene_arguments.hpp"
#include "threads_argument.hpp"

namespace vcell {

class DiagramCommand {
public:
    explicit DiagramCommand(CLI::App& app);

    bool chosen() const { return command_.parsed(); }
    Status run() const;

private:
    CLI::App& command_;
    DiagramSceneArguments scene_;
    std::string cells_, contacts_, groups_, group_contacts_, network_, moments_, cut_;
    ChordArgument chord_;
    std::vector<std::string> outputs_;
    std::optional<std::size_t> most_triangles_;
    bool bodies_ = false;
    ThreadsArgument threads_;
};

}  // namespace vcell
