#include "diagram_output.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <ostream>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>

#include "../files/files.hpp"
#include "../files/itd_file.hpp"
#include "../files/step_file.hpp"
#include "../files/stored_diagram.hpp"
#include "bezier_vtu.hpp"
#include "cell_output.hpp"
#include "conforming_meshes.hpp"
#include "diagram_pictures.hpp"
#include "fitting_chord.hpp"
#include "mesh_formats.hpp"
#include "page.hpp"

namespace vcell {

class DiagramFiles::One {
public:
    One(const std::string& path, const DiagramFileOptions& options)
        : format_(checked_format(path, options)), cut_(options.cut), file_(path) {
        if (format_ == "obj")
            materials_.emplace(std::filesystem::path(path).replace_extension(".mtl").string());
    }

    std::vector<OutputFile*> files() {
        std::vector<OutputFile*> all{&file_};
        if (materials_) all.push_back(&*materials_);
        return all;
    }
    bool has_triangles() const {
        constexpr std::array without{"json", "step", "itd", "bezier.vtu"};
        return std::ranges::find(without, format_) == without.end();
    }

    void begin(const DiagramScene& scene) {
        std::ostream& out = file_.stream();
        if (format_ == "json") writer_.emplace<DiagramWriter>(out, scene);
        if (format_ == "step") writer_.emplace<DiagramStep>(out, scene);
        if (format_ == "itd") writer_.emplace<DiagramItd>(out);
        if (format_ == "bezier.vtu") writer_.emplace<BezierElements>();
        if (format_ == "html") writer_.emplace<DiagramPage>(out, scene);
        if (format_ == "svg") writer_.emplace<DiagramCut>(scene, cut_->axis, cut_->at);
        if (format_ == "obj")
            writer_.emplace<DiagramObj>(out, std::filesystem::path(materials_->target()).filename().string());
        if (is_mesh_format(format_)) writer_.emplace<LabelledMesh>();
    }

    void add(std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
        const auto number = static_cast<std::int32_t>(object);
        if (auto* json = std::get_if<DiagramWriter>(&writer_)) json->add(object, cell);
        if (auto* step = std::get_if<DiagramStep>(&writer_)) step->add(object, cell);
        if (auto* itd = std::get_if<DiagramItd>(&writer_)) itd->add(object, cell);
        if (auto* elements = std::get_if<BezierElements>(&writer_)) elements->add(number, cell);
        if (auto* page = std::get_if<DiagramPage>(&writer_)) page->add(object, cell, mesh);
        if (auto* section = std::get_if<DiagramCut>(&writer_)) section->add(object, cell, mesh);
        if (auto* obj = std::get_if<DiagramObj>(&writer_)) obj->add(object, cell, mesh);
        if (auto* labelled = std::get_if<LabelledMesh>(&writer_))
            labelled->add(number, cell, mesh, colours_.add(object, cell));
    }

    void finish(const VoronoiDiagram& diagram) {
        std::ostream& out = file_.stream();
        if (auto* json = std::get_if<DiagramWriter>(&writer_)) json->finish(diagram);
        if (auto* step = std::get_if<DiagramStep>(&writer_)) step->finish();
        if (auto* elements = std::get_if<BezierElements>(&writer_)) elements->write(out);
        if (auto* page = std::get_if<DiagramPage>(&writer_)) page->finish();
        if (auto* section = std::get_if<DiagramCut>(&writer_)) section->write(out);
        if (auto* labelled = std::get_if<LabelledMesh>(&writer_)) {
            add_numbers(*labelled, diagram);
            write_mesh(out, format_, *labelled);
        }
        if (materials_) DiagramObj::write_mtl(materials_->stream());
    }

private:
    static std::string checked_format(const std::string& path, const DiagramFileOptions& options) {
        const std::string format = format_of(path);
        constexpr std::array others{"json", "obj", "bezier.vtu", "html", "svg", "step", "itd"};
        if (!is_mesh_format(format) && std::ranges::find(others, format) == others.end())
            throw std::invalid_argument(
                path +
                ": an output must end in .json, .obj, .stl, .ply, .vtu, .bezier.vtu, .glb, .3mf, .step, .itd, "
                ".html or .svg");
        if (format == "svg" && !options.cut)
            throw std::invalid_argument(path + ": a picture takes a plane to cut along");
        if (format == "html" && !has_pages())
            throw std::invalid_argument(path + ": three.js was missing when vcell was built");
        return format;
    }

    // The cells' own: where bodies are known, what they leave.
    static void add_numbers(LabelledMesh& mesh, const VoronoiDiagram& diagram) {
        LabelledMesh::Numbers volume{"volume", {}}, porosity{"porosity", {}};
        for (const LabelledMesh::Part& part : mesh.parts) {
            const DiagramCell& cell = diagram.cells[static_cast<std::size_t>(part.cell)];
            volume.of_parts.push_back(cell.volume);
            porosity.of_parts.push_back(1 - cell.body_volume / cell.volume);
        }
        const auto is_known = [](double x) { return !std::isnan(x); };
        if (std::ranges::any_of(porosity.of_parts, is_known))
            mesh.numbers = {std::move(volume), std::move(porosity)};
    }

    const std::string format_;
    const std::optional<DiagramFileOptions::Cut> cut_;
    OutputFile file_;
    std::optional<OutputFile> materials_;
    std::variant<std::monostate, DiagramWriter, DiagramStep, DiagramItd, BezierElements, DiagramPage,
                 DiagramCut, DiagramObj, LabelledMesh>
        writer_;
    CellColours colours_;  // of a mesh
};

DiagramFiles::DiagramFiles(const std::vector<std::string>& paths, const DiagramFileOptions& options)
    : chord_(options.chord), most_triangles_(options.most_triangles) {
    for (const std::string& path : paths) {
        files_.push_back(std::make_unique<One>(path, options));
        std::vector<std::string> all = targets();
        std::ranges::sort(all);
        if (const auto twice = std::ranges::adjacent_find(all); twice != all.end())
            throw std::invalid_argument(*twice + ": given twice");
    }
}
DiagramFiles::~DiagramFiles() = default;

std::vector<std::string> DiagramFiles::targets() const {
    std::vector<std::string> all;
    for (const auto& one : files_)
        for (const OutputFile* file : one->files()) all.push_back(file->target());
    return all;
}

bool DiagramFiles::has_triangles() const {
    return std::ranges::any_of(files_, [](const auto& one) { return one->has_triangles(); });
}

namespace {

// What counts triangles ends when the chord does not fit.
struct GivenUp {};

// A part of what there is to do.
std::function<void(double)> part_of(const std::function<void(double)>& progress, double begin, double end) {
    if (!progress) return nullptr;
    return [=](double fraction) { progress((1 - fraction) * begin + fraction * end); };
}

}  // namespace

// Mostly the chord that is asked for fits, and no cell is drawn with another one.
double DiagramFiles::fitting_chord(const DiagramScene& scene, const DiagramOptions& options) const {
    const std::vector<double> chords = growing_chords(chord_);
    // None: all have been given up.
    const auto found = [&](std::span<const double> some, double begin,
                           double end) -> std::optional<FittingChord> {
        FittingChord fitting(scene, some, *most_triangles_);
        DiagramOptions counting;
        counting.threads = options.threads;
        counting.complete = true;
        counting.progress = part_of(options.progress, begin, end);
        counting.visit = [&](std::uint32_t object, const Cell& cell) {
            if (!fitting.add(object, cell)) throw GivenUp();
        };
        try {
            voronoi_diagram(scene, counting);
        } catch (const GivenUp&) {
            return std::nullopt;
        }
        return fitting;
    };
    const std::span all(chords);
    std::optional<FittingChord> fitting = found(all.first(1), 0, counted_ / 2);
    if (!fitting) fitting = found(all.subspan(1), counted_ / 2, counted_);
    if (fitting->triangles() > *most_triangles_)
        throw TooManyTriangles(*most_triangles_, fitting->triangles());
    return fitting->chord();
}

VoronoiDiagram DiagramFiles::compute(const DiagramScene& scene, DiagramOptions options) {
    if (files_.empty()) return voronoi_diagram(scene, options);
    for (const auto& one : files_) one->begin(scene);
    std::optional<ConformingMeshes> meshes;
    if (has_triangles()) {
        mesh_size_ = MeshSize{chord_, 0};
        if (most_triangles_) {
            mesh_size_->chord = fitting_chord(scene, options);
            options.progress = part_of(options.progress, counted_, 1);
        }
        meshes.emplace(scene, mesh_size_->chord);
    }
    std::vector<bool> is_seen(scene.objects.size(), false);
    options.complete = true;
    options.visit = [&, other = std::move(options.visit)](std::uint32_t object, const Cell& cell) {
        if (other) other(object, cell);
        is_seen[object] = true;
        const CellMesh mesh = meshes ? meshes->add(object, cell) : CellMesh();
        if (mesh_size_) mesh_size_->triangles += mesh.triangles.size();
        for (const auto& one : files_) one->add(object, cell, mesh);
    };
    VoronoiDiagram diagram = voronoi_diagram(scene, options);
    for (const auto& one : files_) one->finish(diagram);
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i)
        if (diagram.cells[i].state == DiagramCell::State::Computed && !is_seen[i])
            without_faces_.push_back(i);
    return diagram;
}

void DiagramFiles::close() {
    for (const auto& one : files_)
        for (OutputFile* file : one->files()) file->close();
}

void DiagramFiles::commit() {
    close();
    for (const auto& one : files_)
        for (OutputFile* file : one->files()) file->commit();
}

}  // namespace vcell
