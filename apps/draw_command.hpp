/// vcell draw: a picture of a cell in space.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "scene_argument.hpp"

namespace vcell {

class DrawCommand {
public:
    explicit DrawCommand(CLI::App& app);

    bool chosen() const { return command_.parsed(); }
    Status run() const;

private:
    Cell cell() const;

    CLI::App& command_;
    SceneArgument scene_;
    std::string output_, view_ = "-60,25";
    std::vector<double> clips_;
    std::size_t size_ = 480;
    bool has_objects_ = true;
};

}  // namespace vcell
