#include "diagram_scene_arguments.hpp"

#include <fmt/format.h>

#include "../io/files/text.hpp"

namespace vcell {

namespace {

std::string axes_complaint(const std::string& text) {
    const bool is_known = !text.empty() && text.find_first_not_of("xyz") == text.npos && text.size() < 4;
    return is_known ? "" : fmt::format("must be some of x, y and z, is {}", printable(text));
}

}  // namespace

void DiagramSceneArguments::add_path_to(CLI::App& command) {
    command.add_option("SCENE", path_, "scene file, JSON or a file of balls; - is standard input")
        ->required();
}

void DiagramSceneArguments::add_to(CLI::App& command) {
    command
        .add_option(
            "--box", box_,
            "the box of a file of balls, instead of its own or one that leaves half their diagonal of room")
        ->expected(6)
        ->check(number_complaint)
        ->type_name("X0 Y0 Z0 X1 Y1 Z1");
    command.add_option("--periodic", periodic_, "the axes along which the box repeats")
        ->check(axes_complaint)
        ->type_name("xyz");
    command
        .add_option("--tilt", tilt_, "how far the edges of a box that repeats lean: (XY, y, 0), (XZ, YZ, z)")
        ->expected(3)
        ->check(number_complaint)
        ->type_name("XY XZ YZ");
    command
        .add_option("--probe", probe_,
                    "radius of a probe: cells end at this clearance, as contacts do, and exposed_area is the "
                    "accessible surface")
        ->check(positive_complaint)
        ->type_name("R");
    files_.add_to(command, "Files of balls");
    files_.add_groups_to(command, "Files of balls");
}

DiagramSceneOptions DiagramSceneArguments::options() const {
    DiagramSceneOptions options;
    options.files = files_.options();
    options.box = box_argument(box_);
    if (!periodic_.empty()) {
        const auto has = [&](char axis) { return periodic_.find(axis) != periodic_.npos; };
        options.periodic = {has('x'), has('y'), has('z')};
    }
    if (!tilt_.empty()) options.tilt = {tilt_[0], tilt_[1], tilt_[2]};
    options.probe = probe_;
    return options;
}

DiagramScene DiagramSceneArguments::read() const {
    return about([&] { return read_diagram_scene(path_, options()); });
}

}  // namespace vcell
