#include "cell_output.hpp"

#include <cstdint>
#include <filesystem>
#include <stdexcept>

#include "../files/cell_file.hpp"
#include "../files/files.hpp"
#include "../files/itd_file.hpp"
#include "../files/step_file.hpp"
#include "mesh_formats.hpp"
#include "obj.hpp"
#include "page.hpp"
#include "svg.hpp"

namespace vcell {

namespace {

void write_as_named(const std::string& path, const Cell& cell, const CellMesh* mesh) {
    std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".stp") ending = ".step";
    const bool is_labelled = ending.size() > 1 && is_mesh_format(ending.substr(1));
    if (!is_labelled && ending != ".json" && ending != ".svg" && ending != ".html" && ending != ".obj" &&
        ending != ".step" && ending != ".itd")
        throw std::invalid_argument(
            "path: must end in .json, .svg, .html, .obj, .stl, .ply, .vtu, .glb, .3mf, .step or .itd, is " +
            path);
    if (ending == ".html" && !has_pages())
        throw std::invalid_argument("path: " + path + ": three.js was missing when vcell was built");
    OutputFile file(path);
    std::ostream& out = file.stream();
    CellMesh own;
    const auto triangles = [&]() -> const CellMesh& {
        if (mesh != nullptr) return *mesh;
        own = tessellate(cell);
        return own;
    };
    if (ending == ".json") write_cell(out, cell);
    if (ending == ".svg") write_svg(out, cell);
    if (ending == ".html") write_page(out, cell, triangles());
    if (ending == ".obj") write_obj(out, cell, triangles(), "");
    if (ending == ".step") write_step(out, cell);
    if (ending == ".itd") write_itd(out, cell);
    if (is_labelled) {
        LabelledMesh labelled;
        labelled.add(cell.scene.base_object ? static_cast<std::int32_t>(*cell.scene.base_object) : -1, cell,
                     triangles());
        write_mesh(out, ending.substr(1), labelled);
    }
    file.commit();
}

}  // namespace

void write_file(const std::string& path, const Cell& cell) { write_as_named(path, cell, nullptr); }
void write_file(const std::string& path, const Cell& cell, const CellMesh& mesh) {
    write_as_named(path, cell, &mesh);
}

}  // namespace vcell
