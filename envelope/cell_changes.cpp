#include "cell_changes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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
    room.probe = scene.probe;
    return room;
}

// What asks for a cell as complete as the one that is changed.
CellOptions keeping(const Cell& cell, CellOptions options) {
    options.complete = options.complete || cell.is_complete;
    return options;
}

// The objects that matter to the cell when others join it. Each ray of a cell that is not complete ends on
// its boundary, and so at one of those that have a part of that; of complete cells' rays some end before they
// come into the box, and what they end at shows nowhere.
Numbers that_matter(const Cell& cell, bool is_complete) {
    if (!is_complete) return neighbors_and_ties(cell);
    Numbers all;
    for (std::uint32_t i = 0; i < cell.scene.objects.size(); ++i)
        if (cell.scene.competes(i)) all.push_back(i);
    return all;
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
    number_by_places(cell);
    const CellOptions kept = keeping(cell, options);
    Numbers among = that_matter(cell, kept.complete);
    Scene scene = std::move(cell.scene);
    among.push_back(static_cast<std::uint32_t>(scene.objects.size()));
    scene.objects.push_back(object);
    if (!scene.names.empty()) scene.names.emplace_back();
    return cell_among(std::move(scene), among, kept);
}

namespace {

// How far numbers of the object reach from the origin, those of its direction aside.
double extent(const Object& object) {
    if (const auto* plane = std::get_if<Plane>(&object)) return plane->point.cwiseAbs().sum();
    if (const auto* ball = std::get_if<Sphere>(&object)) return ball->center.cwiseAbs().sum() + ball->radius;
    const auto& tube = std::get<Cylinder>(object);
    return tube.point.cwiseAbs().sum() + tube.radius;
}

// May the object touch a cell whose clearances are no more than that? Only balls are told to be too far away:
// in a point of the cell, which is in the box, one would be as near as the base is, no farther than the
// clearance, and so no farther than twice that from the base's surface. Both hold inside bodies, too, where
// distances are negative.
bool may_touch(const Object& object, const Scene& scene, double clearance) {
    const auto* ball = std::get_if<Sphere>(&object);
    if (ball == nullptr) return true;
    // Beyond the rounding of a handful of sums of squares.
    constexpr double rounding = 0x1p-46;
    const double slack = rounding * (extent(object) + extent(scene.base) + scene.box.min.cwiseAbs().sum() +
                                     scene.box.max.cwiseAbs().sum());
    const Vec3 nearest = ball->center.cwiseMax(scene.box.min).cwiseMin(scene.box.max);
    const double from_box = (ball->center - nearest).norm() - ball->radius;
    const double from_base = distance_from(scene.base, ball->center) - ball->radius;
    return !(from_box - slack > clearance || from_base - slack > 2 * clearance);
}

}  // namespace

Cell remove(Cell cell, std::uint32_t number, const CellOptions& options) {
    const std::vector<std::uint32_t>& numbers = cell.scene.numbers;
    if (numbers.empty() ? number >= cell.scene.objects.size() : !std::ranges::binary_search(numbers, number))
        throw InputError(InputError::Kind::OutOfRange, number, "objects[" + std::to_string(number) + "]",
                         "is not there to be removed");
    const auto object = static_cast<std::uint32_t>(cell.scene.place(number));
    number_by_places(cell);
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
    const CellOptions kept = keeping(cell, options);
    if (!is_met && !kept.complete) {
        for_each_site(cell, [&](Site& s) {
            if (s.is_object()) s.index = after(s.index);
        });
        for (std::uint32_t& i : cell.neighbors) i = after(i);
        cell.scene = std::move(scene);
        return cell;
    }
    for (std::uint32_t& i : among) i = after(i);
    // The cell among the others lies in that among some of them, and what touches it reaches as far as that.
    // Where some alone leave a cell that is not decided about or refused, others may hide what it is refused
    // for.
    double clearance = std::numeric_limits<double>::infinity();
    CellOptions measured = kept;
    measured.measure = true;
    try {
        const Measures around = cell_among(scene, among, measured).measures;
        clearance = around.max_clearance + around.max_clearance_error;
    } catch (const UndecidedError&) {
    } catch (const InputError&) {
    }
    Numbers candidates;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.competes(i) && may_touch(scene.objects[i], scene, clearance)) candidates.push_back(i);
    return cell_among(std::move(scene), candidates, kept);
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
    if (first.scene.probe != other.probe)
        throw InputError(Kind::Unsupported, InputError::no_object, "probe",
                         "is not the same in cells to be merged");
    if (first.scene.units != other.units)
        throw InputError(Kind::Unsupported, InputError::no_object, "units",
                         "are not the same in cells to be merged");
    if (!other.numbers.empty()) {
        Cell by_places = second;
        number_by_places(by_places);
        return merge(std::move(first), by_places, options);
    }
    number_by_places(first);
    const CellOptions kept = keeping(first, options);
    Numbers among = that_matter(first, kept.complete);
    Scene scene = std::move(first.scene);
    const auto before = static_cast<std::uint32_t>(scene.objects.size());
    for (std::size_t i = 0; i < other.objects.size(); ++i)
        if (other.competes(i)) append(scene, other, i);
    for (const std::uint32_t i : that_matter(second, kept.complete))
        among.push_back(before + i - (other.base_object && i > *other.base_object));
    return cell_among(std::move(scene), among, kept);
}

}  // namespace vcell
