// Exit status 0 when the installed headers and archive compute a cell: the point (0, 0, 1) over the plane
// z = 0 is 1/2 away from the paraboloid halfway.
#include <vcell/vcell.hpp>

int main() {
    vcell::Scene scene;
    scene.base = vcell::Plane{};
    scene.objects = {vcell::Sphere{{0, 0, 1}, 0}};
    scene.box = {{-1, -1, 0}, {1, 1, 4}};
    const vcell::Cell cell = vcell::voronoi_cell(scene);
    return cell.faces.size() == 1 && cell.measures.min_clearance == 0.5 ? 0 : 1;
}
