// Exit status 0 when the installed headers and archive compute a cell: the point (0, 0, 1) over the plane
// z = 0 is 1/2 away from the paraboloid halfway, whose patch has that point above the middle of the box.
#include <vcell/vcell.hpp>

int main() {
    vcell::Scene scene;
    scene.base = vcell::Plane{};
    scene.objects = {vcell::Sphere{{0, 0, 1}, 0}};
    scene.box = {{-1, -1, 0}, {1, 1, 4}};
    const vcell::Cell cell = vcell::voronoi_cell(scene);
    if (cell.faces.size() != 1 || cell.measures.min_clearance != 0.5) return 1;
    const vcell::RationalPatch surface = cell.faces[0].patches[0].surface;
    return (surface.evaluate(0, 0) - vcell::Vec3(0, 0, 0.5)).norm() < 1e-15 ? 0 : 1;
}
