#include "diagram_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <utility>

#include "../io/files/diagram_file.hpp"
#include "../io/files/files.hpp"
#include "../io/files/network_file.hpp"
#include "../io/files/stored_diagram.hpp"
#include "../io/files/text.hpp"
#include "../io/pictures/conforming_meshes.hpp"
#include "../io/pictures/diagram_pictures.hpp"
#include "../io/pictures/mesh_formats.hpp"
#include "../io/pictures/page.hpp"
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

std::string part_complaint(const std::string& text) {
    const auto chord = to_chord(text);
    return chord && chord->is_relative ? "" : fmt::format("must be like 0.2%, is {}", printable(text));
}

// One file of -o.
struct DiagramPicture {
    OutputFile* file = nullptr;
    std::optional<DiagramWriter> text;  // JSON, no picture
    OutputFile* materials = nullptr;
    std::string material_file;
    std::optional<std::pair<int, double>> plane;  // of a cut
    std::string format;
    std::optional<DiagramObj> obj;
    std::optional<LabelledMesh> mesh;
    CellColours colours;  // of the mesh
    std::optional<DiagramCut> cut;
    std::optional<DiagramPage> page;

    void begin(const DiagramScene& scene) {
        if (format == "json")
            text.emplace(file->stream(), scene);
        else if (plane)
            cut.emplace(scene, plane->first, plane->second);
        else if (format == "obj")
            obj.emplace(file->stream(), material_file);
        else if (format == "html")
            page.emplace(file->stream(), scene);
        else
            mesh.emplace();
    }
    void add(std::uint32_t object, const Cell& cell, const CellMesh& of_cell) {
        if (cut) cut->add(object, cell, of_cell);
        if (obj) obj->add(object, cell, of_cell);
        if (page) page->add(object, cell, of_cell);
        if (mesh) mesh->add(static_cast<std::int32_t>(object), cell, of_cell, colours.add(object, cell));
    }
    // The cells' own numbers: where bodies are known, what they leave.
    void set_numbers(const VoronoiDiagram& diagram) {
        if (!mesh) return;
        LabelledMesh::Numbers volume{"volume", {}}, porosity{"porosity", {}};
        for (const LabelledMesh::Part& part : mesh->parts) {
            const DiagramCell& cell = diagram.cells[static_cast<std::size_t>(part.cell)];
            volume.of_parts.push_back(cell.volume);
            porosity.of_parts.push_back(1 - cell.body_volume / cell.volume);
        }
        mesh->numbers = {std::move(volume), std::move(porosity)};
    }
    void end(const VoronoiDiagram& diagram) {
        if (text) text->finish(diagram);
        if (cut) cut->write(file->stream());
        if (page) page->finish();
        if (mesh) write_mesh(file->stream(), format, *mesh);
        if (materials != nullptr) DiagramObj::write_mtl(materials->stream());
    }
};

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
        .add_option("--moments", moments_,
                    "table of the cells of balls: centroid and second moments of the volume")
        ->type_name("FILE");
    command_
        .add_option(
            "-o,--output", outputs_,
            "mesh of all cells, .obj (with .mtl), .stl, .ply, .vtu, .glb or .3mf, a page to look at them, .html, or a "
            "cut through them, .svg, or the cells themselves, .json; may be repeated")
        ->allow_extra_args(false)
        ->type_name("FILE");
    command_
        .add_option(
            "--chord", chord_,
            "meshes: largest distance of a triangle side from the surface, as a part of the cell's diagonal")
        ->check(part_complaint)
        ->type_name("PART%")
        ->capture_default_str();
    command_.add_option("--cut", cut_, "the plane of an .svg: x, y or z = a coordinate")
        ->check(cut_complaint)
        ->type_name("z=VALUE");
    command_
        .add_option(
            "--network", network_,
            "tables of the void network of balls: what spheres fit in and get through, vertices, edges")
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

static DiagramPicture open_picture(const std::string& name, const std::string& plane,
                                   const std::function<OutputFile*(const std::string&)>& open) {
    namespace fs = std::filesystem;
    DiagramPicture picture;
    picture.file = open(name);
    std::string ending = fs::path(name).extension().string();
    std::ranges::transform(ending, ending.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    picture.format = ending.empty() ? ending : ending.substr(1);
    if (ending == ".obj") {
        const fs::path beside = fs::path(name).replace_extension(".mtl");
        picture.material_file = beside.filename().string();
        picture.materials = open(beside.string());
    } else if (ending == ".svg") {
        if (plane.empty()) throw UsageError(fmt::format("{}: a picture takes a plane, --cut z=VALUE", name));
        picture.plane = {plane[0] - 'x', *to_double(plane.substr(plane[2] == '+' ? 3 : 2))};
    } else if (ending == ".html") {
        require_pages(name);
    } else if (ending != ".json" && !is_mesh_format(picture.format)) {
        throw UsageError(fmt::format(
            "{}: an output must end in .json, .obj, .stl, .ply, .vtu, .glb, .3mf, .html or .svg", name));
    }
    return picture;
}

Status DiagramCommand::run() const {
    std::vector<std::unique_ptr<OutputFile>> files;
    const auto open = [&](const std::string& name) -> OutputFile* {
        if (name.empty()) return nullptr;
        for (const auto& other : files)
            if (other->target() == name) throw UsageError(fmt::format("{}: given twice", name));
        return files.emplace_back(std::make_unique<OutputFile>(name)).get();
    };
    std::vector<DiagramPicture> pictures;
    for (const std::string& name : outputs_) pictures.push_back(open_picture(name, cut_, open));
    if (!cut_.empty() && std::ranges::none_of(pictures, [](const auto& p) { return p.format == "svg"; }))
        throw UsageError("--cut: is the plane of an .svg, and no --output is one");
    OutputFile *cells = open(cells_), *pairs = open(contacts_), *groups = open(groups_),
               *voids = open(network_), *moments = open(moments_);
    const bool is_summary_shown =
        std::ranges::none_of(files, [](const auto& f) { return f->target() == "-"; });

    const DiagramScene scene = scene_.read();
    if (moments) write_moment_header(moments->stream());
    scene_.about([&] {
        for (DiagramPicture& picture : pictures) picture.begin(scene);
    });
    const bool has_meshes = std::ranges::any_of(pictures, [](const DiagramPicture& p) { return !p.text; });
    std::vector<bool> is_drawn(scene.objects.size(), false);
    VoronoiDiagram diagram;
    std::optional<VoidNetworkBuilder> network;
    if (voids) scene_.about([&] { network.emplace(scene); });
    std::optional<ConformingMeshes> meshes;
    if (has_meshes) scene_.about([&] { meshes.emplace(scene, to_chord(chord_)->value); });
    {
        ProgressBar bar;
        DiagramOptions options;
        options.threads = threads_.count();
        options.progress = [&](double fraction) { bar.show("cells", fraction); };
        options.complete = !pictures.empty();
        options.bodies = bodies_;
        if (network || moments || !pictures.empty())
            options.visit = [&](std::uint32_t object, const Cell& cell) {
                is_drawn[object] = true;
                if (std::holds_alternative<Sphere>(scene.objects[object])) {
                    if (network) network->add(object, cell);
                    if (moments) write_moment_row(moments->stream(), scene, object, moments_of(cell));
                }
                for (DiagramPicture& picture : pictures)
                    if (picture.text) picture.text->add(object, cell);
                if (!has_meshes) return;
                const CellMesh mesh = meshes->add(object, cell);
                for (DiagramPicture& picture : pictures)
                    if (!picture.text) picture.add(object, cell, mesh);
            };
        diagram = scene_.about([&] { return voronoi_diagram(scene, options); });
    }
    const ContactTable table = contacts(diagram);
    for (DiagramPicture& picture : pictures) {
        if (bodies_) picture.set_numbers(diagram);
        picture.end(diagram);
    }
    if (cells) write_cell_table(cells->stream(), scene, diagram);
    if (pairs) write_contact_table(pairs->stream(), scene, table);
    if (groups) write_group_table(groups->stream(), scene, diagram, table);
    // Where there is no network, the other tables are written all the same.
    bool has_network = true;
    if (network) try {
            write_network(voids->stream(), scene_.about([&] { return network->finish(diagram); }));
        } catch (const UndecidedError& e) {
            warn(e.what());
            has_network = false;
            std::erase_if(files, [&](const auto& file) { return file.get() == voids; });
        }
    for (const auto& file : files) file->close();
    for (const auto& file : files) file->commit();

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
        if (!pictures.empty() && cell.state == DiagramCell::State::Computed && !is_drawn[i])
            warn(fmt::format("{} object {}: its cell is measured, but has no faces",
                             has_meshes ? "no picture of" : "no cell in the file of", i));
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
