/// The scene of a whole diagram on the command line, with what its file leaves open.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../io/files/diagram_file.hpp"
#include "ball_file_arguments.hpp"
#include "command.hpp"

namespace vcell {

class DiagramSceneArguments {
public:
    /// The file comes first, and its options after those of outputs.
    void add_path_to(CLI::App& command);
    void add_to(CLI::App& command);

    const std::string& path() const { return path_; }
    // Pre of all that follows: the command line was parsed.
    DiagramSceneOptions options() const;
    /// Throws as read_diagram_scene(), with the file's name.
    DiagramScene read() const;
    /// f(), whose complaints are about the scene and name its file.
    template <class F>
    auto about(F f) const {
        return about_file(path_, "", f);
    }

private:
    std::string path_, periodic_;
    std::vector<double> box_, tilt_;
    std::optional<double> probe_;
    BallFileArguments files_;
};

}  // namespace vcell
