/// How coarse the meshes of a diagram's cells are.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "command.hpp"

namespace vcell {

class ChordArgument {
public:
    void add_to(CLI::App& command) {
        command
            .add_option(
                "--chord", text_,
                "meshes: largest distance of a triangle side from the surface, as a part of the cell's diagonal")
            ->check(part_complaint)
            ->type_name("PART%")
            ->capture_default_str();
    }
    /// As the user writes it. Pre, here and below: the command line was parsed.
    const std::string& text() const { return text_; }
    double part() const { return to_chord(text_)->value; }

private:
    std::string text_ = "0.2%";
};

}  // namespace vcell
