#include "draw_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>

#include "../io/files/cell_file.hpp"
#include "../io/files/files.hpp"
#include "../io/files/text.hpp"
#include "../io/pictures/view.hpp"
#include "png.hpp"

namespace vcell {

namespace {

// "-60,25" in degrees.
std::optional<Vec2> to_view(std::string_view text) {
    const std::size_t comma = text.find(',');
    if (comma == text.npos) return std::nullopt;
    const std::optional<double> azimuth = to_double(text.substr(0, comma)),
                                elevation = to_double(text.substr(comma + 1));
    if (!azimuth || !elevation || !std::isfinite(*azimuth) || !(std::abs(*elevation) <= 90))
        return std::nullopt;
    return Vec2(*azimuth, *elevation);
}
std::string view_complaint(const std::string& text) {
    return to_view(text)
               ? ""
               : fmt::format("must be azimuth,elevation in degrees, the latter from -90 to 90, is {}",
                             printable(text));
}

}  // namespace

DrawCommand::DrawCommand(CLI::App& app)
    : command_(*app.add_subcommand("draw", "draw a cell in space, with base and objects")) {
    scene_.add_to(
        command_, "CELL_OR_SCENE",
        "cell file, or a scene whose cell is computed: JSON or a file of balls; - is standard input");
    command_.add_option("-o,--output", output_, "the picture, .png")->required()->type_name("FILE");
    command_
        .add_option("--view", view_,
                    "where the viewer is, in degrees: from the x axis towards y, and upwards from there to z")
        ->check(view_complaint)
        ->type_name("AZIMUTH,ELEVATION")
        ->capture_default_str();
    command_.add_option("--size", size_, "width and height in pixels")
        ->check(CLI::Range(16, 4096))
        ->capture_default_str();
    command_.add_flag("--objects,!--no-objects", has_objects_, "with base and objects (default), or without");
    command_
        .add_option("--clip", clips_,
                    "of the cell only what is on that side of a plane, a point of it and its normal; may be "
                    "repeated")
        ->type_size(6)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->check(number_complaint)
        ->type_name("X Y Z NX NY NZ");
    command_.footer(
        "Faces have the colours that they have in other pictures, and are as translucent as objects are; planes\n"
        "and cylinders end at the box. Parallel projection.\n\n"
        "Examples:\n"
        "  vcell draw examples/scenes/figure8.json -o cell.png --view -53,22");
}

Cell DrawCommand::cell() const {
    const std::string text = read_file(scene_.path);
    return scene_.about([&] {
        if (auto cell = parse_if_cell(text)) return std::move(*cell);
        return compute_cell(scene_.parse(text));
    });
}

Status DrawCommand::run() const {
    const bool is_png = std::filesystem::path(output_).extension() == ".png";
    if (!is_png && output_ != "-") throw UsageError(fmt::format("{}: a picture must end in .png", output_));
    if (!has_png())
        throw UsageError(fmt::format(
            "{}: this program was built without libpng and writes no .png (Debian's package is libpng-dev)",
            output_));
    OutputFile file(output_);
    ViewOptions options;
    const Vec2 view = *to_view(view_);
    options.azimuth = view.x();
    options.elevation = view.y();
    options.size = size_;
    options.has_objects = has_objects_;
    for (std::size_t i = 0; i + 5 < clips_.size(); i += 6) {
        if (clips_[i + 3] == 0 && clips_[i + 4] == 0 && clips_[i + 5] == 0)
            throw UsageError("--clip: the normal NX NY NZ must not be zero");
        options.clips.push_back(
            {{clips_[i], clips_[i + 1], clips_[i + 2]}, {clips_[i + 3], clips_[i + 4], clips_[i + 5]}});
    }
    const Cell drawn = cell();
    // Where the cell fills the picture no chord is seen, and where much of it is clipped hardly one.
    constexpr double of_pixel = 0.125;
    MeshOptions mesh;
    mesh.chord = of_pixel / static_cast<double>(options.size) * cell_diagonal(drawn);
    write_png(file.stream(), draw_view(drawn, tessellate(drawn, mesh), options));
    file.commit();
    return report(drawn);
}

}  // namespace vcell
