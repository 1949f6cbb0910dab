/// The scene that a command is told, and its cell.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "../envelope/cell.hpp"
#include "ball_file_arguments.hpp"
#include "command.hpp"

namespace vcell {

/// The scene argument of a command, with what a plain file leaves open.
class SceneArgument {
public:
    std::string path;

    void add_to(CLI::App& command, const char* name = "SCENE",
                const char* help = "scene file, JSON or a file of balls; - is standard input");

    /// f(), whose complaints are about the scene and name its file.
    template <class F>
    auto about(F f) const {
        return about_file(path, "", f);
    }

    Scene read() const;
    /// The scene of the file's text. Throws InputError without the file's name.
    Scene parse(std::string_view text) const;

private:
    std::size_t base_ = 0;
    std::vector<double> base_plane_, box_;
    BallFileArguments files_;
    CLI::Option* has_base_ = nullptr;
};

/// With a progress bar.
Cell compute_cell(const Scene& scene, unsigned threads = 1, bool is_complete = false);

/// Warnings, and whether every question was decided.
Status report(const Cell& cell);

}  // namespace vcell
