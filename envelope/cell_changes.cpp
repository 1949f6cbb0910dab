#include "cell_changes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "../core/errors.hpp"
#include "object_distance.hpp"

namespace vcell {

namespace {

using Numbers = std::vector<std::uint32_t>;

// Appends an object of `from`, name included.
void append(Scene& scene, const Scene& from, std::size_t place) {
    const std::string name = place < from.names.size() ? from.names[place] : std::string();
    if (!name.empty() || !scene.names.empty()) {
        scene.names.resize(scene.objects.size());
        scene.names.push_back(name);
    }
    scene.objects.push_back(from.objects[place]);
}

// The scene without the objects, their names and what numbers them.
Scene room(const Scene& scene) {
    Scene room;
    room.base = scene.base;
    room.base_name = scene.base_name;
    room.box = scene.box;
    room.units = scene.units;
    room.tolerance = scene.tolerance;
    return room;
}

// What asks for a cell as complete as the one that is changed.
CellOptions keeping(const Cell& cell, CellOptions options) {
    options.complete = options.complete || cell.is_complete;
    return options;
}

// The cell of a scene if no other objects than these, ascending, matter.
Cell cell_among(Scene scene, const Numbers& objects, const CellOptions& options) {
    Scene part = room(scene);
    part.numbers = objects;
    for (const std::uint32_t i : objects) append(part, scene, i);
    Cell cell = voronoi_cell(part, options);
    cell.scene = std::move(scene);
    return cell;
}

}  // namespace

std::vector<std::uint32_t> neighbors_and_ties(const Cell& cell) {
    Numbers all;
    for_each_site(cell, [&](const Site& s) {
        if (s.is_object()) all.push_back(s.index);
    });
    std::ranges::sort(all);
    all.erase(std::ranges::unique(all).begin(), all.end());
    return all;
}

Cell insert(Cell cell, const Object& object, const CellOptions& options) {
    Numbers among = neighbors_and_ties(cell);
    Scene scene = std::move(cell.scene);
    among.push_back(static_cast<std::uint32_t>(scene.objects.size()));
    scene.objects.push_back(object);
    if (!scene.names.empty()) scene.names.emplace_back();
    return cell_among(std::move(scene), among, keeping(cell, options));
}

namespace {

// A lower bound of the distance of a ball from the base region, which lies in the box; of other objects 0.
double least_distance(const Object& object, const Scene& scene) {
    const auto* ball = std::get_if<Sphere>(&object);
    if (ball == nullptr) return 0;
    // Beyond the rounding of a handful of sums of squares.
    constexpr double rounding = 0x1p-46;
    const Vec3 nearest = ball->center.cwiseMax(scene.box.min).cwiseMin(scene.box.max);
    const double distance =
        std::max((ball->center - nearest).norm(), distance_from(scene.base, ball->center));
    const double size = ball->center.cwiseAbs().sum() + scene.box.min.cwiseAbs().sum() +
                        scene.box.max.cwiseAbs().sum() + ball->radius;
    return distance - ball->radius - rounding * size;
}

}  // namespace

Cell remove(Cell cell, std::uint32_t object, const CellOptions& options) {
    if (object >= cell.scene.objects.size())
        throw InputError(InputError::Kind::OutOfRange, object, "objects[" + std::to_string(object) + "]",
                         "is not there to be removed");
    if (!cell.scene.competes(object))
        throw InputError(InputError::Kind::Unsupported, object, object_path(cell.scene, object),
                         "is the base and cannot be removed");
    Numbers among = neighbors_and_ties(cell);
    const auto place = std::ranges::lower_bound(among, object);
    const bool is_met = place != among.end() && *place == object;
    if (is_met) among.erase(place);

    const auto after = [object](std::uint32_t i) { return i > object ? i - 1 : i; };
    Scene scene = std::move(cell.scene);
    scene.objects.erase(scene.objects.begin() + object);
    if (object < scene.names.size()) scene.names.erase(scene.names.begin() + object);
    if (scene.base_object) scene.base_object = after(*scene.base_object);
    if (!is_met) {
        for_each_site(cell, [&](Site& s) {
            if (s.is_object()) s.index = after(s.index);
        });
        for (std::uint32_t& i : cell.neighbors) i = after(i);
        cell.scene = std::move(scene);
        return cell;
    }
    for (std::uint32_t& i : among) i = after(i);
    // The cell among the others lies in that among some of them. An object that touches it is as near to a
    // point of it as the base is, which is no farther than the clearance r, and no farther than 2 r from the
    // base.
    CellOptions measured = keeping(cell, options);
    measured.measure = true;
    const Measures around = cell_among(scene, among, measured).measures;
    const double reach = 2 * (around.max_clearance + around.max_clearance_error);
    Numbers candidates;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.competes(i) && !(least_distance(scene.objects[i], scene) > reach)) candidates.push_back(i);
    return cell_among(std::move(scene), candidates, keeping(cell, options));
}

Cell merge(Cell first, const Cell& second, const CellOptions& options) {
    using Kind = InputError::Kind;
    const Scene& other = second.scene;
    if (first.scene.base != other.base)
        throw InputError(Kind::Unsupported, InputError::no_object, "base",
                         "is not the same in cells to be merged");
    if (first.scene.box.min != other.box.min || first.scene.box.max != other.box.max)
        throw InputError(Kind::Unsupported, InputError::no_object, "box",
                         "is not the same in cells to be merged");
    Numbers among = neighbors_and_ties(first);
    Scene scene = std::move(first.scene);
    const auto before = static_cast<std::uint32_t>(scene.objects.size());
    for (std::size_t i = 0; i < other.objects.size(); ++i)
        if (other.competes(i)) append(scene, other, i);
    for (const std::uint32_t i : neighbors_and_ties(second))
        among.push_back(before + i - (other.base_object && i > *other.base_object));
    return cell_among(std::move(scene), among, keeping(first, options));
}

}  // namespace vcell
