#include "complete_cells.hpp"

#include <optional>
#include <utility>
#include <variant>

#include "../../core/errors.hpp"
#include "../voronoi_cell.hpp"

namespace vcell::whole {

std::vector<Scene> scenes_among_all(const DecidedDiagram& decided, std::uint32_t object) {
    const DiagramScene& all = decided.scene();
    Scene scene;
    scene.base = all.objects[object];
    if (object < all.names.size()) scene.base_name = all.names[object];
    scene.box = all.box;
    scene.units = all.units;
    scene.tolerance = all.tolerance;
    scene.probe = all.probe;
    for (std::uint32_t x = 0; x < all.objects.size(); ++x) {
        if (x == object || !decided.hidden(x).empty()) continue;
        scene.objects.push_back(all.objects[x]);
        scene.numbers.push_back(decided.number(x));
        if (!all.names.empty()) scene.names.push_back(all.names[x]);
    }
    std::vector<Scene> scenes{std::move(scene)};
    if (const auto* plane = std::get_if<Plane>(&all.objects[object])) {
        scenes.push_back(scenes.front());
        scenes.back().base = Plane{plane->point, -plane->normal};
    }
    return scenes;
}

std::vector<Cell> complete_cells(const DecidedDiagram& decided, std::uint32_t object) {
    CellOptions options;
    options.complete = true;
    std::vector<Cell> cells;
    for (const Scene& scene : scenes_among_all(decided, object)) try {
            cells.push_back(voronoi_cell(scene, options));
        } catch (const UndecidedError&) {
        } catch (const InputError&) {
        }
    return cells;
}

WholeCells find_whole_cells(const DecidedDiagram& decided, std::uint32_t object) {
    std::optional<Cell> cell;
    WholeCells found{find_cell(decided, object, &cell), {}};
    if (cell)
        found.cells.push_back(*std::move(cell));
    else if (!decided.is_ball(object) && found.measured.state == DiagramCell::State::Computed)
        found.cells = complete_cells(decided, object);
    return found;
}

}  // namespace vcell::whole
