// Reads a scene; computes, checks, meshes and writes its cell; asks whose a point of the box is; adds up the
// volumes of the cells of all objects. scene_to_files SCENE FOLDER
#include <iostream>
#include <vcell/io.hpp>

int main(int, char** arguments) {
    const std::string folder = arguments[2];
    const vcell::Scene scene = vcell::read_scene(arguments[1]);
    const vcell::Cell cell = vcell::voronoi_cell(scene);
    const vcell::CellMesh mesh = vcell::tessellate(cell, {.closed = true});
    vcell::write_file(folder + "/cell.json", cell);  // the format is the ending's: .step, .vtu, ...
    vcell::write_file(folder + "/cell.obj", cell, mesh);

    const vcell::Certificate certificate = vcell::certify(vcell::read_cell(folder + "/cell.json"));
    const auto answer = vcell::PointQuery(scene)((scene.box.min + scene.box.max) / 2);
    const vcell::DiagramScene all = vcell::read_diagram_scene(arguments[1]);
    const vcell::FilledVolume filled = vcell::filled_volume(all, vcell::voronoi_diagram(all));
    std::cout << cell.faces.size() << " faces, volume " << cell.measures.volume << ", "
              << (certificate.holds() ? "proved" : "not proved") << "; the middle is nearest to "
              << to_string(*answer->site) << "; all cells fill " << filled.volume / filled.box
              << " of the box\n";
}
