#include "complete_cells.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "../../core/errors.hpp"
#include "../object_distance.hpp"
#include "../voronoi_cell.hpp"
#include "tube_bound.hpp"
#include "tube_room.hpp"

namespace vcell::whole {

namespace {

// A lower bound of how far two axes are from each other: of those that are all but parallel 0.
double distance_of_axes(const Cylinder& a, const Cylinder& b) {
    const Vec3 along = a.axis.stableNormalized(), other = b.axis.stableNormalized(), way = b.point - a.point,
               normal = along.cross(other);
    const double size = a.point.cwiseAbs().sum() + b.point.cwiseAbs().sum(), sine = normal.norm();
    constexpr double rounding = 0x1p-40, well_told = 0x1p-10;
    if (a.axis == b.axis) return way.cross(along).norm() - rounding * size;
    return sine > well_told ? std::abs(way.dot(normal)) / sine - rounding * size / well_told : 0;
}

// A box that is wider on both sides, along the axes that repeat.
Box grown(const Lattice& lattice, Box box, double by) {
    for (int k = 0; k < 3; ++k) {
        if (!lattice.repeats(k)) continue;
        box.min[k] -= by;
        box.max[k] += by;
    }
    return box;
}

double distance_of(const Box& box, const Vec3& p) {
    return (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm();
}

// All images that may be as near as an object to one of the points of a box which are no farther than
// `clearance` from it.
class NearImages {
public:
    NearImages(const DecidedDiagram& decided, std::uint32_t object, const Box& box, double clearance)
        : decided_(decided),
          whose_(decided.scene().objects[object]),
          box_(box),
          clearance_(clearance * (1 + 0x1p-40)) {
        struct Found {
            ObjectImage place;
            Object object;
        };
        std::vector<Found> found;
        const auto add = [&](const Object& moved, std::uint32_t place, const Image& image) {
            if (may_come_near(moved)) found.push_back({{place, image}, moved});
        };
        const Vec3 middle = 0.5 * (box.min + box.max);
        const double reach = 0.5 * box.diagonal() + clearance_;
        decided.balls().within(
            middle, reach,
            [&](const Sphere& ball, std::uint32_t place, const Image& image) { add(ball, place, image); });
        for (const DecidedDiagram::Other& other : decided.others())
            other.images.near(middle, reach, [&](const Object& moved, const Image& image) {
                if (other.place != object || image != Image{0, 0, 0}) add(moved, other.place, image);
            });
        std::ranges::sort(found, {}, &Found::place);
        for (const Found& f : found) {
            places_.push_back(f.place);
            objects_.push_back(f.object);
        }
    }

    /// What they leave of the tube's cell in a box over feet between these.
    TubeBound bound(const Cylinder& tube, const std::array<Vec3, 2>& feet, const Box& box) const {
        return {tube, feet, box, objects_, decided_.scene().probe};
    }

    /// Those that may touch the bound.
    void put_into(Scene& scene, const TubeBound* bound) const {
        const std::vector<std::string>& names = decided_.scene().names;
        for (std::size_t k = 0; k < objects_.size(); ++k) {
            if (bound != nullptr && !bound->may_touch(objects_[k])) continue;
            const ObjectImage& which = places_[k];
            scene.objects.push_back(objects_[k]);
            scene.images.push_back({decided_.number(which.number), which.image});
            if (!names.empty()) scene.names.push_back(names[which.number]);
        }
    }

private:
    bool may_come_near(const Object& object) const {
        const auto* tube = std::get_if<Cylinder>(&whose_);
        if (const auto* ball = std::get_if<Sphere>(&object))
            return distance_of(box_, ball->center) - ball->radius < clearance_ &&
                   (tube == nullptr || least_distance(*tube, *ball) < 2 * clearance_);
        const auto* other = std::get_if<Cylinder>(&object);
        return tube == nullptr || other == nullptr ||
               distance_of_axes(*tube, *other) - tube->radius - other->radius < 2 * clearance_;
    }

    const DecidedDiagram& decided_;
    const Object& whose_;
    const Box box_;
    const double clearance_;
    std::vector<ObjectImage> places_;  // ascending
    std::vector<Object> objects_;
};

void add_all(const DecidedDiagram& decided, std::uint32_t object, Scene& scene) {
    const DiagramScene& all = decided.scene();
    for (std::uint32_t x = 0; x < all.objects.size(); ++x) {
        if (x == object || !decided.hidden(x).empty()) continue;
        scene.objects.push_back(all.objects[x]);
        scene.numbers.push_back(decided.number(x));
        if (!all.names.empty()) scene.names.push_back(all.names[x]);
    }
}

void add_images(const DecidedDiagram& decided, std::uint32_t object, Scene& scene) {
    const double most = scene.probe.value_or(infinity);
    const auto* tube = std::get_if<Cylinder>(&decided.scene().objects[object]);
    if (tube == nullptr) {
        // What is nearest to a plane in the box is within its diagonal. Scenes may have corners on the sides.
        for (int k = 0; k < 3; ++k) {
            if (!decided.lattice().repeats(k)) continue;
            const double step = part_before_cut * (scene.box.max[k] - scene.box.min[k]);
            scene.box.min[k] += step;
            scene.box.max[k] += step;
        }
        NearImages(decided, object, scene.box, std::min(scene.box.diagonal(), most)).put_into(scene, nullptr);
        return;
    }
    const std::span<const Image> periods = decided.periods(object);
    const auto room_within = [&](double farthest) {
        return tube_room(decided.lattice(), scene.box, *tube, periods, farthest);
    };
    const TubeRoom wide = room_within(infinity);
    const NearImages near(decided, object, wide.box, std::min(wide.clearance, most));
    // What has its feet in one period tells how far all of the cell reaches; where the tube leans it comes
    // out of the planes of the cut. Of a cell that ends at sides which do not repeat it could not be told
    // from the cell that it does not come back into the box beyond a narrower one.
    TubeRoom room = wide;
    if (!periods.empty()) {
        const Box around = grown(decided.lattice(), wide.box, wide.clearance + tube->radius);
        room = room_within(near.bound(*tube, wide.axis, around).farthest());
    }
    scene.box = room.box;
    const TubeBound bound = near.bound(*tube, room.feet, wide.box);
    near.put_into(scene, &bound);
}

}  // namespace

Scene scene_without_others(const DecidedDiagram& decided, std::uint32_t object) {
    const DiagramScene& all = decided.scene();
    Scene scene;
    scene.base = all.objects[object];
    if (object < all.names.size()) scene.base_name = all.names[object];
    scene.box = all.box;
    scene.units = all.units;
    scene.tolerance = all.tolerance;
    scene.probe = all.probe;
    return scene;
}

std::vector<Scene> scenes_among_all(const DecidedDiagram& decided, std::uint32_t object) {
    Scene scene = scene_without_others(decided, object);
    if (decided.scene().is_periodic())
        add_images(decided, object, scene);
    else
        add_all(decided, object, scene);
    std::vector<Scene> scenes{std::move(scene)};
    if (const auto* plane = std::get_if<Plane>(&decided.scene().objects[object])) {
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
