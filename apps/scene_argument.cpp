#include "scene_argument.hpp"

#include <fmt/format.h>

#include "../envelope/voronoi_cell.hpp"
#include "../io/files/files.hpp"
#include "../io/files/scene_file.hpp"
#include "../io/files/text.hpp"
#include "progress.hpp"

namespace vcell {

static std::string ball_complaint(const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
    return digits && text.size() < 10
               ? ""
               : fmt::format("must be the number of a ball, counted from 0, is {}", printable(text));
}

void SceneArgument::add_to(CLI::App& command, const char* name, const char* help) {
    command.add_option(name, path, help)->required();
    const char* group = "Files of balls";
    has_base_ = command.add_option("--base", base_, "the ball that is the base, counted from 0")
                    ->check(ball_complaint)
                    ->type_name("K")
                    ->group(group);
    command.add_option("--base-plane", base_plane_, "the base plane: a point of it and its normal")
        ->expected(6)
        ->check(number_complaint)
        ->type_name("X Y Z NX NY NZ")
        ->excludes(has_base_)
        ->group(group);
    command
        .add_option("--box", box_,
                    "the box, instead of one about the balls that leaves half its diagonal of room")
        ->expected(6)
        ->check(number_complaint)
        ->type_name("X0 Y0 Z0 X1 Y1 Z1")
        ->group(group);
    files_.add_to(command, group);
}

Scene SceneArgument::parse(std::string_view text) const {
    TextSceneOptions options;
    options.files = files_.options();
    const auto vec = [](const std::vector<double>& v, std::size_t i) {
        return Vec3(v[i], v[i + 1], v[i + 2]);
    };
    if (has_base_->count() > 0) options.base_ball = base_;
    if (!base_plane_.empty()) options.base_plane = Plane{vec(base_plane_, 0), vec(base_plane_, 3)};
    options.box = box_argument(box_);
    return parse_scene(text, options);
}

Scene SceneArgument::read() const {
    return about([&] { return parse(read_file(path)); });
}

Cell compute_cell(const Scene& scene, unsigned threads, bool is_complete) {
    ProgressBar bar;
    CellOptions options;
    options.threads = threads;
    options.complete = is_complete;
    options.progress = [&](const char* stage, double fraction) { bar.show(stage, fraction); };
    return voronoi_cell(scene, options);
}

Status report(const Cell& cell) {
    for (const std::string& w : cell.report.warnings) warn(w);
    return report_assumed(cell.report.decisions.assumed);
}

}  // namespace vcell
