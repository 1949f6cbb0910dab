#include "diagram_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <ostream>

#include "../io/files/diagram_file.hpp"
#include "../io/files/files.hpp"
#include "../io/files/text.hpp"
#include "progress.hpp"

namespace vcell {

namespace {

std::string axes_complaint(const std::string& text) {
    const bool is_known = !text.empty() && text.find_first_not_of("xyz") == text.npos && text.size() < 4;
    return is_known ? "" : fmt::format("must be some of x, y and z, is {}", printable(text));
}
std::string threads_complaint(const std::string& text) { return text == "0" ? "" : count_complaint(text); }

}  // namespace

DiagramCommand::DiagramCommand(CLI::App& app)
    : command_(*app.add_subcommand("diagram", "the cells of all objects")) {
    command_
        .add_option("SCENE", path_, "scene file, JSON or x y z r [name [group]] lines; - is standard input")
        ->required();
    command_.add_option("--cells", cells_, "table of the cells: volume, area, neighbours, clearance")
        ->type_name("FILE");
    command_
        .add_option("--contacts", contacts_, "table of the pairs of neighbours: area, distance, direction")
        ->type_name("FILE");
    command_.add_option("--groups", groups_, "table of the groups of objects: their cells as one")
        ->type_name("FILE");
    command_
        .add_option("--box", box_,
                    "the box of x y z r lines, instead of one that leaves half their diagonal of room")
        ->expected(6)
        ->check(number_complaint)
        ->type_name("X0 Y0 Z0 X1 Y1 Z1");
    command_.add_option("--periodic", periodic_, "the axes along which the box repeats")
        ->check(axes_complaint)
        ->type_name("xyz");
    command_
        .add_option("--tilt", tilt_, "how far the edges of a box that repeats lean: (XY, y, 0), (XZ, YZ, z)")
        ->expected(3)
        ->check(number_complaint)
        ->type_name("XY XZ YZ");
    command_
        .add_option(
            "--probe", probe_,
            "radius of a probe: cells of balls end at this clearance, as contacts do, and exposed_area is the "
            "accessible surface")
        ->check(number_complaint)
        ->type_name("R");
    command_
        .add_option("--threads", threads_,
                    "how many to compute with, 0 for all cores; the result is the same")
        ->check(threads_complaint)
        ->type_name("N")
        ->capture_default_str();
    command_.footer(
        "Every cell is proved complete: no object that was left out can touch it. Prints the number of cells, what\n"
        "their volumes add up to and the box's volume. Tables are tab-separated, with error bounds. Exit status 3 if\n"
        "a cell could not be decided; the others are in the tables all the same.");
}

Status DiagramCommand::run() const {
    std::vector<std::unique_ptr<OutputFile>> files;
    const auto open = [&](const std::string& name) -> OutputFile* {
        if (name.empty()) return nullptr;
        for (const auto& other : files)
            if (other->target() == name) throw UsageError(fmt::format("{}: given twice", name));
        return files.emplace_back(std::make_unique<OutputFile>(name)).get();
    };
    OutputFile *cells = open(cells_), *pairs = open(contacts_), *groups = open(groups_);
    const bool is_summary_shown =
        std::ranges::none_of(files, [](const auto& f) { return f->target() == "-"; });

    DiagramSceneOptions reading;
    if (!box_.empty()) reading.box = Box{{box_[0], box_[1], box_[2]}, {box_[3], box_[4], box_[5]}};
    if (!periodic_.empty()) {
        const auto has = [&](char axis) { return periodic_.find(axis) != periodic_.npos; };
        reading.periodic = {has('x'), has('y'), has('z')};
    }
    if (!tilt_.empty()) reading.tilt = {tilt_[0], tilt_[1], tilt_[2]};
    reading.probe = probe_;
    const DiagramScene scene = about_file(path_, "", [&] { return read_diagram_scene(path_, reading); });
    VoronoiDiagram diagram;
    {
        ProgressBar bar;
        DiagramOptions options;
        options.threads = static_cast<unsigned>(std::stoul(threads_));
        options.progress = [&](double fraction) { bar.show("cells", fraction); };
        diagram = about_file(path_, "", [&] { return voronoi_diagram(scene, options); });
    }
    const ContactTable table = contacts(diagram);
    if (cells) write_cell_table(cells->stream(), scene, diagram);
    if (pairs) write_contact_table(pairs->stream(), scene, table);
    if (groups) write_group_table(groups->stream(), scene, diagram, table);
    for (const auto& file : files) file->close();
    for (const auto& file : files) file->commit();

    std::size_t computed = 0, empty = 0;
    std::uint64_t assumed = 0;
    for (std::size_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        assumed += cell.assumed;
        if (cell.state == DiagramCell::State::Computed) ++computed;
        if (cell.state == DiagramCell::State::Empty) ++empty;
        if (cell.state == DiagramCell::State::Undecided || cell.state == DiagramCell::State::Refused)
            warn(fmt::format("no cell of object {}: {}", i, cell.reason));
    }
    for (const std::string& fault : table.faults) warn(fault);
    const FilledVolume sum = filled_volume(scene, diagram);
    if (is_summary_shown) {
        OutputFile out("-");
        out.stream() << "cells\tempty\tcontacts\tvolume\tvolume_error\tbox\testimated\n"
                     << fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{:d}\n", computed, empty, table.contacts.size(),
                                    sum.volume, sum.error, sum.box, sum.is_estimated);
        out.commit();
    }
    const bool is_whole = computed + empty == diagram.cells.size() && table.faults.empty();
    const Status status = report_assumed(assumed);
    return is_whole ? status : undecided;
}

}  // namespace vcell
