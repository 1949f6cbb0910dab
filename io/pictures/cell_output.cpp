#include "cell_output.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include "../files/cell_file.hpp"
#include "../files/files.hpp"
#include "../files/itd_file.hpp"
#include "../files/step_file.hpp"
#include "bezier_vtu.hpp"
#include "mesh_formats.hpp"
#include "obj.hpp"
#include "page.hpp"
#include "site_style.hpp"
#include "svg.hpp"

namespace vcell {

namespace {

void write_as_named(const std::string& path, const Cell& cell, const CellMesh* mesh) {
    const std::string format = format_of(path);
    const bool is_labelled = is_mesh_format(format);
    constexpr std::array others{"json", "svg", "html", "obj", "bezier.vtu", "step", "itd"};
    if (!is_labelled && std::ranges::find(others, format) == others.end())
        throw std::invalid_argument(
            "path: must end in .json, .svg, .html, .obj, .stl, .ply, .vtu, .bezier.vtu, .glb, .3mf, .step or .itd, is " +
            path);
    if (format == "html" && !has_pages())
        throw std::invalid_argument("path: " + path + ": three.js was missing when vcell was built");
    OutputFile file(path);
    std::ostream& out = file.stream();
    CellMesh own;
    const auto triangles = [&]() -> const CellMesh& {
        if (mesh != nullptr) return *mesh;
        own = tessellate(cell);
        return own;
    };
    if (format == "json") write_cell(out, cell);
    if (format == "svg") write_svg(out, cell);
    if (format == "html") write_page(out, cell, triangles());
    if (format == "obj") write_obj(out, cell, triangles(), "");
    if (format == "bezier.vtu") write_bezier_vtu(out, cell);
    if (format == "step") write_step(out, cell);
    if (format == "itd") write_itd(out, cell);
    if (is_labelled) {
        LabelledMesh labelled;
        labelled.add(base_number(cell.scene), cell, triangles());
        write_mesh(out, format, labelled);
    }
    file.commit();
}

}  // namespace

std::string format_of(const std::string& path) {
    const std::filesystem::path file(path);
    std::string format = file.extension().string();
    std::ranges::transform(format, format.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (!format.empty()) format.erase(0, 1);
    if (format == "stp") return "step";
    return format == "vtu" && file.stem().extension() == ".bezier" ? "bezier.vtu" : format;
}

void write_file(const std::string& path, const Cell& cell) { write_as_named(path, cell, nullptr); }
void write_file(const std::string& path, const Cell& cell, const CellMesh& mesh) {
    write_as_named(path, cell, &mesh);
}

}  // namespace vcell
