// The vcell program: reads scenes, computes and judges cells, writes them. Thin: what it does is the
// library's.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>

#include "../core/errors.hpp"
#include "../core/platform.hpp"
#include "../envelope/complete_measures.hpp"
#include "../envelope/measures/clearance_places.hpp"
#include "../envelope/point_query.hpp"
#include "../envelope/vertex_refinement.hpp"
#include "../io/files/text.hpp"
#include "../io/io.hpp"
#include "../io/pictures/site_style.hpp"
#include "check_command.hpp"
#include "command.hpp"
#include "diagram_command.hpp"
#include "draw_command.hpp"
#include "scene_argument.hpp"
#include "threads_argument.hpp"

namespace vcell {

namespace {

constexpr const char* program_help = R"(The Voronoi cell of a base object among others, exact.)";

constexpr const char* program_footer = R"(
Examples, with files of vcell's source:
  vcell compute examples/scenes/figure8.json -o cell.json -o diagram.svg -o cell.step
  vcell compute examples/scenes/figure8.json -o cell.html
  vcell draw examples/scenes/figure8.json -o cell.png --view -60,25
  echo 0.1 0.2 0.3 | vcell query examples/scenes/figure8.json
  vcell measure examples/scenes/figure8.json
  vcell diagram tests/data/1CRN.xyzr --cells cells.tsv --contacts contacts.tsv
  vcell compute examples/scenes/figure8.json -o - | vcell check -
  vcell refine cell.json --bits 200

A file named - is standard input or output. Scenes are JSON or files of balls: plain "x y z r" lines, PDB,
mmCIF, XYZ and extended XYZ, LAMMPS dumps.
Exit status: 0 done, 1 wrong usage or an output that cannot be written, 2 bad input, 3 a question that
could not be decided, 4 a check that failed or left something open. "vcell COMMAND --help" tells more.)";

// ---- compute -------------------------------------------------------------------------------------

class Compute {
public:
    explicit Compute(CLI::App& app)
        : command_(*app.add_subcommand("compute", "compute the cell of a scene")) {
        scene_.add_to(command_);
        command_
            .add_option(
                "-o,--output", outputs_,
                "output file, .json, .svg, .html (a page to look at), .obj (with .mtl), .stl, .ply, .vtu, "
                ".bezier.vtu, .glb, .3mf, .step or .itd; may be repeated")
            ->required()
            ->allow_extra_args(false)
            ->type_name("FILE");
        command_
            .add_option(
                "--format", format_,
                "format of standard output: json, svg, html, obj, stl, ply, vtu, bezier.vtu, glb, 3mf, step or itd")
            ->check(CLI::IsMember({"json", "svg", "html", "obj", "stl", "ply", "vtu", "bezier.vtu", "glb",
                                   "3mf", "step", "itd"}))
            ->capture_default_str();
        command_
            .add_option(
                "--chord", chord_,
                "meshes: largest distance of a triangle side from the surface, a length, or with % a part "
                "of the cell's diagonal")
            ->check(chord_complaint)
            ->type_name("LENGTH")
            ->capture_default_str();
        command_
            .add_option(
                "--triangles", most_triangles_,
                "meshes: the chord grows until they have no more; otherwise, beyond 1000000, until only edges "
                "ask for them")
            ->check(count_complaint)
            ->type_name("N");
        command_.add_flag("--solid", solid_, "meshes: with walls and base, closed");
        command_.add_flag(
            "--complete", complete_,
            "of a base plane or an oblique tube: all that is nearest to it in the box, over base points outside "
            "it, too");
        command_.add_flag("--moments", moments_,
                          "in .json: the volume's centroid and second moments, with their errors");
        command_.add_flag("--clearances", clearances_,
                          "in .json: where the least and the greatest clearance are, with their errors");
        command_
            .add_option("--contours", contours_,
                        "in .svg: level curves of the clearance, at N round levels at most")
            ->check(CLI::Range(1, 1000))
            ->type_name("N");
        threads_.add_to(command_);
        command_.footer(
            "No output appears before all of them are complete.\n\n"
            "Examples:\n"
            "  vcell compute examples/scenes/figure8.json -o cell.json -o cell.step\n"
            "  vcell compute examples/scenes/pile_50.json -o cell.stl --solid --chord 1%\n"
            "  vcell compute tests/data/1CRN.xyzr --base 17 -o atom.html");
    }

    bool chosen() const { return command_.parsed(); }

    Status run() {
        // Every target is opened before the work: what cannot be written is known at once.
        for (const std::string& target : outputs_) add(target);
        const Scene scene = scene_.read();
        Cell cell = scene_.about([&] { return compute_cell(scene, threads_.count(), complete_); });
        if (moments_) cell.moments = moments_of(cell);
        if (clearances_) cell.clearance_places = clearance_places(cell);
        if (complete_ && !cell.is_complete)
            warn(
                "the cell stands over what the box holds of the base: only those of planes and of "
                "oblique tubes can be completed");
        std::optional<CellMesh> mesh;
        for (const auto& out : files_) {
            if (takes_mesh(out->format) && !mesh) mesh = mesh_of(cell);
            write(*out, cell, mesh);
        }
        for (const auto& out : files_) out->file.close();
        for (const auto& out : files_) out->file.commit();
        return report(cell);
    }

private:
    struct Output {
        OutputFile file;
        std::string format;
        std::string material_file;
    };

    static bool takes_mesh(const std::string& format) {
        return format == "obj" || format == "html" || is_mesh_format(format);
    }

    void add(const std::string& target) {
        namespace fs = std::filesystem;
        std::string format = format_;
        std::string material_file;
        if (target != "-") {
            format = format_of(target);
            if (format != "json" && format != "svg" && format != "bezier.vtu" && format != "itd" &&
                format != "step" && !takes_mesh(format))
                throw UsageError(
                    fmt::format("{}: an output must end in .json, .svg, .html, .obj, .stl, .ply, .vtu, "
                                ".bezier.vtu, .glb, .3mf, .step or .itd",
                                target));
        }
        if (format == "html") require_pages(target);
        if (format == "obj" && target != "-") {
            const fs::path beside = fs::path(target).replace_extension(".mtl");
            material_file = beside.filename().string();
            open(beside.string(), "mtl", "");
        }
        open(target, format, material_file);
    }

    void open(const std::string& target, const std::string& format, const std::string& material_file) {
        for (const auto& other : files_)
            if (other->file.target() == target) throw UsageError(fmt::format("{}: given twice", target));
        files_.push_back(std::unique_ptr<Output>(new Output{OutputFile(target), format, material_file}));
    }

    CellMesh mesh_of(const Cell& cell) const {
        const Chord chord = *to_chord(chord_);
        const double wanted = chord.is_relative ? chord.value * cell_diagonal(cell) : chord.value;
        CellMesh mesh = tessellate(cell, {wanted, solid_, most_triangles_});
        if (mesh.chord > wanted)
            warn_of_chord(fmt::format("{:.3g}", wanted), most_triangles_.value_or(MeshOptions::usually_most),
                          mesh.triangles.size(), fmt::format("{:.3g}", mesh.chord));
        return mesh;
    }

    void write(Output& out, const Cell& cell, const std::optional<CellMesh>& mesh) const {
        std::ostream& stream = out.file.stream();
        if (out.format == "json") write_cell(stream, cell, threads_.count());
        if (out.format == "svg") write_svg(stream, cell, {contours_});
        if (out.format == "bezier.vtu") write_bezier_vtu(stream, cell);
        if (out.format == "itd") write_itd(stream, cell);
        if (out.format == "step") write_step(stream, cell);
        if (out.format == "obj") write_obj(stream, cell, *mesh, out.material_file);
        if (out.format == "html") write_page(stream, cell, *mesh);
        if (out.format == "mtl") write_mtl(stream, cell);
        if (!is_mesh_format(out.format)) return;
        LabelledMesh labelled;
        labelled.add(base_number(cell.scene), cell, *mesh);
        write_mesh(stream, out.format, labelled);
    }

    CLI::App& command_;
    SceneArgument scene_;
    std::vector<std::string> outputs_;
    std::string format_ = "json";
    std::string chord_ = "0.1%";
    std::optional<std::size_t> most_triangles_;
    bool solid_ = false;
    bool complete_ = false;
    bool moments_ = false;
    bool clearances_ = false;
    std::size_t contours_ = 0;
    ThreadsArgument threads_;
    std::vector<std::unique_ptr<Output>> files_;
};

// ---- query ---------------------------------------------------------------------------------------

class Query {
public:
    explicit Query(CLI::App& app)
        : command_(*app.add_subcommand("query", "who is nearest above a base point?")) {
        scene_.add_to(command_);
        command_.add_option("POINTS", points_, "file of x y z lines")->capture_default_str();
        command_.footer(
            "Prints for each point a line \"site clearance inside\": the site that owns the ray through the\n"
            "point along the base's normal (the first of those that tie), the height of the cell's boundary\n"
            "on that ray, and true if the point lies in the cell, false if not. A ray from outside the base\n"
            "region has no owner: \"- - false\". The centre of a base sphere, or a point on a base cylinder's\n"
            "axis, has no ray: \"- - true\".\n\n"
            "Examples:\n"
            "  echo 0.1 0.2 0.3 | vcell query examples/scenes/figure8.json");
    }

    bool chosen() const { return command_.parsed(); }

    Status run() const {
        if (scene_.path == "-" && points_ == "-")
            throw UsageError("query: scene and points cannot both come from standard input");
        const Scene scene = scene_.read();
        const std::vector<Vec3> points = about_file(points_, "points", [&] { return read_points(); });
        const std::string answers = scene_.about([&] { return answer(PointQuery(scene), points); });
        OutputFile out("-");
        out.stream() << answers;
        out.commit();
        return done;
    }

private:
    static std::string answer(PointQuery query, const std::vector<Vec3>& points) {
        for (const std::string& w : query.warnings()) warn(w);
        std::string answers;
        for (const Vec3& p : points) {
            const auto a = query(p);
            if (a && a->site)
                fmt::format_to(std::back_inserter(answers), "{} {} {}\n", to_string(*a->site), a->clearance,
                               a->inside);
            else
                fmt::format_to(std::back_inserter(answers), "- - {}\n", a && a->inside);
        }
        return answers;
    }

    std::vector<Vec3> read_points() const {
        const std::string bytes = read_file(points_);
        const std::string_view text = without_byte_order_mark(bytes);
        std::vector<Vec3> points;
        std::size_t line_number = 0;
        for (std::size_t at = 0; at < text.size();) {
            std::string_view line = next_line(text, at);
            ++line_number;
            std::vector<double> numbers;
            for (std::string_view word; !(word = next_word(line)).empty();)
                numbers.push_back(parse_number(word, line_number));
            if (numbers.empty()) continue;
            if (numbers.size() != 3)
                throw InputError(InputError::Kind::Syntax, InputError::no_object,
                                 fmt::format("line {}", line_number),
                                 fmt::format("must be x y z, has {} numbers", numbers.size()));
            points.emplace_back(numbers[0], numbers[1], numbers[2]);
        }
        return points;
    }

    CLI::App& command_;
    SceneArgument scene_;
    std::string points_ = "-";
};

// ---- measure -------------------------------------------------------------------------------------

class Measure {
public:
    explicit Measure(CLI::App& app)
        : command_(*app.add_subcommand("measure", "volume, areas and clearances")) {
        scene_.add_to(command_);
        command_.add_flag("--complete", complete_,
                          "of all that is nearest to the base in the box, over base points outside it, too");
        for (Table& table : tables_)
            command_.add_option(table.option, table.path, table.help)
                ->type_name("FILE")
                ->excludes("--complete");
        command_.footer(
            "Prints a header and one line, tab-separated.\n\n"
            "Examples:\n"
            "  vcell measure examples/scenes/figure8.json --faces faces.tsv --clearances clearances.tsv\n"
            "  vcell measure examples/scenes/leaning.json --complete");
    }

    bool chosen() const { return command_.parsed(); }

    Status run() const {
        const Scene scene = scene_.read();
        if (complete_) return run_complete(scene);
        const Cell cell = scene_.about([&] { return compute_cell(scene); });
        const Measures& m = cell.measures;
        OutputFile out("-");
        out.stream()
            << "volume\tvolume_error\tbody_volume\tarea\tarea_error\tbox_area\tbase_area\t"
               "min_clearance\tmax_clearance\ttouches_box\tfaces\tedges\tvertices\tneighbors\testimated\n"
            << fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{:d}\n", m.volume,
                           m.volume_error, m.body_volume, m.area, m.area_error, m.box_area, m.base_area,
                           m.min_clearance, m.max_clearance, m.touches_box, cell.faces.size(),
                           cell.edges.size(), cell.vertices.size(), cell.neighbors.size(), m.is_estimated);
        out.commit();
        for (const Table& table : tables_) {
            if (table.path.empty()) continue;
            OutputFile file(table.path);
            table.write(file.stream(), cell);
            file.commit();
        }
        return report(cell);
    }

private:
    struct Table {
        const char *option, *help;
        void (*write)(std::ostream&, const Cell&);
        std::string path{};
    };

    Status run_complete(const Scene& scene) const {
        const CompleteMeasures m = scene_.about([&] { return complete_measures(scene); });
        OutputFile out("-");
        out.stream() << "volume\tvolume_error\tarea\tarea_error\tneighbors\testimated\n"
                     << fmt::format("{}\t{}\t{}\t{}\t{}\t{:d}\n", m.volume, m.volume_error, m.area,
                                    m.area_error, m.neighbors.size(), m.is_estimated);
        out.commit();
        return report_assumed(m.assumed);
    }

    CLI::App& command_;
    SceneArgument scene_;
    bool complete_ = false;
    std::array<Table, 5> tables_{
        {{"--faces", "table of the faces: site, name, bisector, area", write_faces},
         {"--edges", "table of the edges: sites, names, kind, length, dihedral angle", write_edges},
         {"--vertices", "table of the vertices: point, clearance, sites, names", write_vertices},
         {"--clearances",
          "table of where the least and the greatest clearance are, with the element that holds each",
          write_clearances},
         {"--moments", "table of the volume's centroid and second moments", write_moments}}};
};

// ---- refine --------------------------------------------------------------------------------------

class Refine {
public:
    explicit Refine(CLI::App& app)
        : command_(*app.add_subcommand("refine", "vertices of a cell file to more digits")) {
        command_.add_option("CELL", path_, "cell file, JSON; - is standard input")->required();
        command_.add_option("--vertex", vertices_, "only these, counted from 0");
        command_.add_option("--bits", bits_, "within 2^-BITS of the box's diagonal")
            ->check(CLI::Range(1, most_refined_bits))
            ->capture_default_str();
        command_.footer(
            "Prints a table, tab-separated: the vertex; three of its sites that fix it with the base; x, y, z\n"
            "and clearance, of which the last digit may be off by one; and a bound on how far the vertex is from\n"
            "being equally far from its other sites, 0 if it has none. Exit status 3 if a vertex has no line:\n"
            "where bisectors touch, no three sites fix it.\n\n"
            "Examples:\n"
            "  vcell compute examples/scenes/figure8.json -o cell.json && vcell refine cell.json --bits 200");
    }

    bool chosen() const { return command_.parsed(); }

    Status run() const {
        const Cell cell = about_file(path_, "", [&] { return read_cell(path_); });
        std::vector<std::size_t> vertices = vertices_;
        if (!command_.count("--vertex")) {
            vertices.resize(cell.vertices.size());
            std::iota(vertices.begin(), vertices.end(), std::size_t{0});
        }
        // Digits after the point.
        const double unit = std::ldexp(cell.scene.box.diagonal(), -bits_);
        const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(unit))));
        std::string table = "vertex\tsites\tx\ty\tz\tclearance\ttie_width\n";
        bool is_whole = true;
        for (const std::size_t v : vertices) {
            if (v >= cell.vertices.size())
                throw UsageError(
                    fmt::format("refine: there is no vertex {}, but {} of them", v, cell.vertices.size()));
            if (const auto refined = refine(cell, v, bits_)) {
                append(table, v, *refined, digits);
            } else {
                warn(fmt::format("vertex {}: no three of its sites are proved to fix it", v));
                is_whole = false;
            }
        }
        OutputFile out("-");
        out.stream() << table;
        out.commit();
        return is_whole ? done : undecided;
    }

private:
    static void append(std::string& table, std::size_t v, const RefinedVertex& refined, int digits) {
        const auto& [a, b, c] = refined.sites;
        fmt::format_to(std::back_inserter(table), "{}\t{},{},{}", v, to_string(a), to_string(b),
                       to_string(c));
        for (const Wide& side : refined.box)
            table += '\t' + side.mid().lower().str(digits, std::ios_base::fixed);
        fmt::format_to(std::back_inserter(table), "\t{:.3g}\n", refined.tie_width);
    }

    CLI::App& command_;
    std::string path_;
    std::vector<std::size_t> vertices_;
    int bits_ = 128;
};

int run(int argc, char** argv) {
    CLI::App app(program_help, "vcell");
    app.footer(program_footer);
    // With two blanks after `-o,--output FILE ... REQUIRED`: help2man takes one for a part of the option.
    constexpr std::size_t option_width = 33;
    app.get_formatter()->column_width(option_width);
    app.set_version_flag("--version", "vcell " VCELL_VERSION);
    app.require_subcommand(1);
    app.failure_message([](const CLI::App* program, const CLI::Error& e) {
        const auto used = program->get_subcommands();
        return fmt::format("vcell: {}; \"vcell {}--help\" tells more\n", e.what(),
                           used.empty() ? "" : used.front()->get_name() + ' ');
    });
    Compute compute(app);
    DrawCommand draw(app);
    Query query(app);
    Measure measure(app);
    CheckCommand check(app);
    Refine refine(app);
    DiagramCommand diagram(app);
    const auto is_asked_for = [&](CLI::App* command) { return command->check_name(argv[1]); };
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(is_asked_for).empty())
        throw UsageError(
            fmt::format("there is no command \"{}\"; \"vcell --help\" tells which there are", argv[1]));
    try {
        app.parse(arguments(argc, argv));
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? done : wrong_usage;
    }
    if (compute.chosen()) return compute.run();
    if (draw.chosen()) return draw.run();
    if (query.chosen()) return query.run();
    if (measure.chosen()) return measure.run();
    if (check.chosen()) return check.run();
    if (diagram.chosen()) return diagram.run();
    return refine.run();
}

}  // namespace

}  // namespace vcell

int main(int argc, char** argv) {
    using namespace vcell;
    std::ios::sync_with_stdio(false);
    remove_unfinished_on_signals();
    try {
        return run(argc, argv);
    } catch (...) {
        const Failure failure = failure_of_exception();
        fmt::print(stderr, "vcell: {}\n", failure.text);
        return failure.status;
    }
}
