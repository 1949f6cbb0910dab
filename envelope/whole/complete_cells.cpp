#include "complete_cells.hpp"

#include <variant>

#include "../../core/errors.hpp"
#include "../voronoi_cell.hpp"

namespace vcell::whole {

std::vector<Cell> complete_cells(const DecidedDiagram& decided, std::uint32_t object) {
    const DiagramScene& all = decided.scene();
    Scene scene;
    scene.box = all.box;
    scene.units = all.units;
    scene.tolerance = all.tolerance;
    if (object < all.names.size()) scene.base_name = all.names[object];
    for (std::uint32_t x = 0; x < all.objects.size(); ++x) {
        if (x == object || !decided.hidden(x).empty()) continue;
        scene.objects.push_back(all.objects[x]);
        scene.numbers.push_back(decided.number(x));
        if (!all.names.empty()) scene.names.push_back(all.names[x]);
    }
    std::vector<Object> bases{all.objects[object]};
    if (const auto* plane = std::get_if<Plane>(&all.objects[object]))
        bases.push_back(Plane{plane->point, -plane->normal});
    CellOptions options;
    options.complete = true;
    std::vector<Cell> cells;
    for (const Object& base : bases) {
        scene.base = base;
        try {
            cells.push_back(voronoi_cell(scene, options));
        } catch (const UndecidedError&) {
        } catch (const InputError&) {
        }
    }
    return cells;
}

}  // namespace vcell::whole
