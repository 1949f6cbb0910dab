#include "ball_file_arguments.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "../io/files/text.hpp"

namespace vcell {

namespace {

std::string frame_complaint(const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
    return digits && text.size() < 10
               ? ""
               : fmt::format("must be the number of a frame, counted from 0, is {}", printable(text));
}

std::string radius_complaint(const std::string& text) {
    const std::size_t sign = text.rfind('=');
    const bool has_both = sign != text.npos && sign > 0;
    const std::optional<double> value =
        has_both ? to_double(std::string_view(text).substr(sign + 1)) : std::nullopt;
    return value && std::isfinite(*value) && *value >= 0
               ? ""
               : fmt::format("must be an element or a type, '=' and its radius, is {}", printable(text));
}

}  // namespace

void BallFileArguments::add_to(CLI::App& command, const char* group) {
    command.add_option("--frame", frame_, "the model, frame or timestep to read, counted from 0")
        ->check(frame_complaint)
        ->type_name("N")
        ->group(group);
    command
        .add_option("--radius", radii_,
                    "the radius of an element, species or type that the file gives none of; may be repeated")
        ->check(radius_complaint)
        ->allow_extra_args(false)
        ->type_name("KIND=R")
        ->group(group);
    command.add_flag("--hydrogens", has_hydrogens_, "PDB, mmCIF: read hydrogens, too")->group(group);
    command.add_flag("--no-water", leaves_water_, "PDB, mmCIF: read no water")->group(group);
    command.add_flag("--no-hetero", leaves_hetero_, "PDB, mmCIF: read no HETATM atoms")->group(group);
}

void BallFileArguments::add_groups_to(CLI::App& command, const char* group) {
    command.add_option("--group", group_, "PDB, mmCIF: what atoms are grouped by, residue or chain")
        ->check(CLI::IsMember({"residue", "chain"}))
        ->group(group);
}

BallFileOptions BallFileArguments::options() const {
    BallFileOptions options;
    if (!frame_.empty()) options.frame = std::stoul(frame_);
    for (const std::string& text : radii_) {
        const std::size_t sign = text.rfind('=');
        options.radii[text.substr(0, sign)] = *to_double(std::string_view(text).substr(sign + 1));
    }
    options.has_hydrogens = has_hydrogens_;
    options.leaves_water = leaves_water_;
    options.leaves_hetero = leaves_hetero_;
    if (!group_.empty())
        options.group = group_ == "chain" ? BallFileOptions::Group::Chain : BallFileOptions::Group::Residue;
    return options;
}

}  // namespace vcell
