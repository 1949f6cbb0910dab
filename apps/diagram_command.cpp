#include "diagram_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string_view>

#include "../io/files/diagram_file.hpp"
#include "../io/files/files.hpp"
#include "../io/files/network_file.hpp"
#include "../io/files/text.hpp"
#include "../io/pictures/cell_output.hpp"
#include "../io/pictures/diagram_output.hpp"
#include "../io/solids/moments.hpp"
#include "progress.hpp"

namespace vcell {

namespace {

// "z=0.5"
std::string cut_complaint(const std::string& text) {
    const bool is_known = text.size() > 2 && text[0] >= 'x' && text[0] <= 'z' && text[1] == '=' &&
                          number_complaint(text.substr(2)).empty();
    return is_known ? "" : fmt::format("must be like z=0.5, is {}", printable(text));
}

// Wrong usage is what the files' library takes for an invalid argument.
std::unique_ptr<DiagramFiles> open_files(const std::vector<std::string>& paths, double chord,
                                         std::optional<std::size_t> most_triangles, const std::string& cut) {
    DiagramFileOptions options;
    options.chord = chord;
    options.most_triangles = most_triangles;
    if (!cut.empty())
        options.cut = {cut[0] - 'x', *to_double(std::string_view(cut).substr(cut[2] == '+' ? 3 : 2))};
    const auto is_picture = [](const std::string& path) { return format_of(path) == "svg"; };
    if (options.cut && std::ranges::none_of(paths, is_picture))
        throw UsageError("--cut: is the plane of an .svg, and no --output is one");
    if (const auto picture = std::ranges::find_if(paths, is_picture); !options.cut && picture != paths.end())
        throw UsageError(fmt::format("{}: a picture takes a plane, --cut z=VALUE", *picture));
    try {
        return std::make_unique<DiagramFiles>(paths, options);
    } catch (const std::invalid_argument& e) {
        throw UsageError(e.what());
    }
}

}  // namespace

DiagramCommand::DiagramCommand(CLI::App& app)
    : command_(*app.add_subcommand("diagram", "the cells of all objects")) {
    scene_.add_path_to(command_);
    command_.add_option("--cells", cells_, "table of the cells: volume, area, neighbours, clearance")
        ->type_name("FILE");
    command_.add_flag(
        "--bodies", bodies_,
        "what the objects themselves take of their cells, too: columns body_volume and body_error of "
        "--cells, and what they leave of the box, its porosity");
    command_
        .add_option("--contacts", contacts_, "table of the pairs of neighbours: area, distance, direction")
        ->type_name("FILE");
    command_.add_option("--groups", groups_, "table of the groups of objects: their cells as one")
        ->type_name("FILE");
    command_
        .add_option("--group-contacts", group_contacts_,
                    "table of the pairs of groups that are neighbours: area")
        ->type_name("FILE");
    command_
        .add_option("--moments", moments_,
                    "table of the cells of balls: centroid and second moments of the volume")
        ->type_name("FILE");
    command_
        .add_option(
            "-o,--output", outputs_,
            "mesh of all cells, .obj (with .mtl), .stl, .ply, .vtu, .glb or .3mf, a page to look at them, .html, a cut "
            "through them, .svg, or the cells themselves, .step, .itd, .bezier.vtu or .json; may be repeated")
        ->allow_extra_args(false)
        ->type_name("FILE");
    chord_.add_to(command_);
    command_
        .add_option("--triangles", most_triangles_,
                    "meshes: the chord grows until all cells together have no more")
        ->check(count_complaint)
        ->type_name("N");
    command_.add_option("--cut", cut_, "the plane of an .svg: x, y or z = a coordinate")
        ->check(cut_complaint)
        ->type_name("z=VALUE");
    command_
        .add_option(
            "--network", network_,
            "tables of the void network: what spheres fit in and get through, vertices, edges, passages; of FILE.csv as "
            "OpenPNM reads it")
        ->type_name("FILE");
    scene_.add_to(command_);
    threads_.add_to(command_);
    command_.footer(
        "Files of balls are x y z r [name [group]] lines, PDB, mmCIF, XYZ, extended XYZ or a LAMMPS dump.\n"
        "Every cell is proved complete: no object that was left out can touch it. Prints the number of cells, what\n"
        "their volumes add up to and the box's volume. Tables are tab-separated, with error bounds. Exit status 3 if\n"
        "a cell could not be decided; the others are in the tables all the same.\n\n"
        "Examples:\n"
        "  vcell diagram tests/data/1CRN.xyzr --probe 1.4 --cells cells.tsv --contacts contacts.tsv\n"
        "  vcell diagram tests/data/crambin_head.pdb --no-water --group residue --groups residues.tsv\n"
        "  echo 0 0 0 1.1 | vcell diagram - --box 0 0 0 2 2 2 --periodic xyz --bodies -o cell.vtu");
}

Status DiagramCommand::run() const {
    const std::unique_ptr<DiagramFiles> outputs = open_files(outputs_, chord_.part(), most_triangles_, cut_);
    std::vector<std::unique_ptr<OutputFile>> files;
    const auto open = [&](const std::string& name) -> OutputFile* {
        if (name.empty()) return nullptr;
        std::vector<std::string> targets = outputs->targets();
        for (const auto& other : files) targets.push_back(other->target());
        if (std::ranges::find(targets, name) != targets.end())
            throw UsageError(fmt::format("{}: given twice", name));
        return files.emplace_back(std::make_unique<OutputFile>(name)).get();
    };
    OutputFile *cells = open(cells_), *pairs = open(contacts_), *groups = open(groups_),
               *group_pairs = open(group_contacts_), *voids = open(network_), *moments = open(moments_);
    const bool is_summary_shown =
        std::ranges::none_of(files, [](const auto& f) { return f->target() == "-"; });

    const DiagramScene scene = scene_.read();
    if (moments) write_moment_header(moments->stream());
    VoronoiDiagram diagram;
    std::optional<VoidNetworkBuilder> network;
    if (voids) scene_.about([&] { network.emplace(scene); });
    {
        ProgressBar bar;
        DiagramOptions options;
        options.threads = threads_.count();
        options.progress = [&](double fraction) { bar.show("cells", fraction); };
        options.bodies = bodies_;
        options.complete = network.has_value();
        if (network || moments)
            options.visit = [&](std::uint32_t object, const Cell& cell) {
                if (network) network->add(object, cell);
                if (moments && std::holds_alternative<Sphere>(scene.objects[object]))
                    write_moment_row(moments->stream(), scene, object, moments_of(cell));
            };
        diagram = scene_.about([&] { return outputs->compute(scene, options); });
    }
    const ContactTable table = contacts(diagram);
    if (cells) write_cell_table(cells->stream(), scene, diagram);
    if (pairs) write_contact_table(pairs->stream(), scene, table);
    if (groups) write_group_table(groups->stream(), scene, diagram, table);
    if (group_pairs) write_group_contacts(group_pairs->stream(), scene, table);
    // Where there is no network, the other tables are written all the same.
    bool has_network = true;
    if (network) try {
            const VoidNetwork found = scene_.about([&] { return network->finish(diagram); });
            if (format_of(network_) == "csv")
                write_openpnm(voids->stream(), found);
            else
                write_network(voids->stream(), found);
        } catch (const UndecidedError& e) {
            warn(e.what());
            has_network = false;
            std::erase_if(files, [&](const auto& file) { return file.get() == voids; });
        }
    for (const auto& file : files) file->close();
    outputs->commit();
    for (const auto& file : files) file->commit();

    if (const auto& size = outputs->mesh_size(); size && size->chord > chord_.part())
        warn_of_chord(chord_.text(), *most_triangles_, size->triangles,
                      fmt::format("{:.3g}%", 100 * size->chord));
    for (const std::uint32_t i : outputs->without_faces())
        warn(fmt::format("no cell in the files of object {}: it is measured, but has no faces", i));

    // Fibres that cross at random leave every other one without a cell.
    constexpr std::size_t most_named = 10;
    std::size_t computed = 0, empty = 0, walls = 0, refused = 0, lacking = 0;
    std::uint64_t assumed = 0;
    for (std::size_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        assumed += cell.assumed;
        if (cell.state == DiagramCell::State::Computed) ++computed;
        if (cell.state == DiagramCell::State::Empty) ++empty;
        if (cell.state == DiagramCell::State::Wall) ++walls;
        if (cell.state != DiagramCell::State::Undecided && cell.state != DiagramCell::State::Refused)
            continue;
        if (cell.state == DiagramCell::State::Refused) ++refused;
        if (++lacking <= most_named)
            warn(fmt::format("no cell of object {}, the base here: {}", i, cell.reason));
    }
    if (lacking > most_named)
        warn(fmt::format(
            "{} objects have no cells, {} of them as they cut or touch others, {} undecided; the columns "
            "state and reason of --cells FILE name each",
            lacking, refused, lacking - refused));
    for (const std::string& fault : table.faults) warn(fault);
    const FilledVolume sum = filled_volume(scene, diagram), bodies = body_volume(scene, diagram);
    if (is_summary_shown) {
        OutputFile out("-");
        std::string header = "cells\tempty\tcontacts\tvolume\tvolume_error\tbox\testimated",
                    line = fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{:d}", computed, empty, table.contacts.size(),
                                       sum.volume, sum.error, sum.box,
                                       sum.is_estimated || (bodies_ && bodies.is_estimated));
        if (bodies_) {
            header += "\tbodies\tbodies_error\tporosity";
            line += std::isfinite(bodies.volume) ? fmt::format("\t{}\t{}\t{}", bodies.volume, bodies.error,
                                                               1 - bodies.volume / bodies.box)
                                                 : "\t-\t-\t-";
        }
        out.stream() << header << '\n' << line << '\n';
        out.commit();
    }
    const bool is_whole =
        computed + empty + walls == diagram.cells.size() && table.faults.empty() && has_network;
    const Status status = report_assumed(assumed);
    return is_whole ? status : undecided;
}

}  // namespace vcell
