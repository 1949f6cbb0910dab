// The Voronoi cell of the plane z = 0 among three spheres and a slanted plane, inside a box.
#include <cstdio>
#include <vcell/vcell.hpp>

int main() {
    vcell::Scene scene;
    scene.base = vcell::Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = {vcell::Sphere{{0.2, 0.1, 0.9}, 0.25}, vcell::Sphere{{-0.5, 0.3, 1.1}, 0.1},
                     vcell::Sphere{{0.1, -0.6, 0.8}, 0.0}, vcell::Plane{{0, 0, 1.8}, {0.1, 0, -1}}};
    scene.box = {{-1, -1, 0}, {1, 1, 2}};

    const vcell::Cell cell = vcell::voronoi_cell(scene);

    std::printf("%zu faces, %zu edges, %zu vertices\n", cell.faces.size(), cell.edges.size(),
                cell.vertices.size());
    for (const vcell::CellFace& face : cell.faces) {
        std::printf("%-8s %-12s area %.6f\n", to_string(face.site).c_str(), face.bisector.c_str(), face.area);
    }
    std::printf("volume %.6f, clearance %.6f to %.6f\n", cell.measures.volume, cell.measures.min_clearance,
                cell.measures.max_clearance);
}
