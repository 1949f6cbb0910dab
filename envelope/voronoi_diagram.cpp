#include "voronoi_diagram.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "../core/errors.hpp"
#include "../core/platform.hpp"
#include "../core/threads.hpp"
#include "whole/cell_finder.hpp"

namespace vcell {

namespace {

// Some cells at a time are held for `visit`, which has them in order.
constexpr std::size_t cells_at_a_time = 256;

void compute(const whole::DecidedDiagram& decided, const std::vector<std::uint32_t>& which,
             VoronoiDiagram& diagram, const DiagramOptions& options) {
    const unsigned threads = thread_count(options.threads);
    for (std::size_t begin = 0; begin < which.size(); begin += cells_at_a_time) {
        const std::size_t count = std::min(cells_at_a_time, which.size() - begin);
        std::vector<std::optional<Cell>> cells(options.visit ? count : 0);
        for_all(count, threads, [&](std::size_t i) {
            const std::uint32_t object = which[begin + i];
            diagram.cells[object] = whole::find_cell(decided, object, options.visit ? &cells[i] : nullptr);
        });
        for (std::size_t i = 0; i < cells.size(); ++i)
            if (cells[i]) options.visit(which[begin + i], *cells[i]);
        if (options.progress)
            options.progress(static_cast<double>(begin + count) / static_cast<double>(which.size()));
    }
}

std::string name_of(std::uint32_t object, const std::array<std::int16_t, 3>& image) {
    std::string text = std::to_string(object);
    if (image != std::array<std::int16_t, 3>{0, 0, 0})
        text += " (" + std::to_string(image[0]) + ", " + std::to_string(image[1]) + ", " +
                std::to_string(image[2]) + ")";
    return text;
}

}  // namespace

Eigen::Matrix3d DiagramScene::edges() const {
    const Vec3 size = box.max - box.min;
    Eigen::Matrix3d m;
    m << size.x(), tilt[0], tilt[1], 0, size.y(), tilt[2], 0, 0, size.z();
    return m;
}

VoronoiDiagram voronoi_diagram(const DiagramScene& scene, const DiagramOptions& options) {
    return in_ieee_arithmetic("voronoi_diagram()", [&] {
        const whole::DecidedDiagram decided(scene);
        VoronoiDiagram diagram;
        diagram.moved = decided.moved();
        diagram.cells.resize(scene.objects.size());
        std::vector<std::uint32_t> all(scene.objects.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
        compute(decided, all, diagram, options);
        return diagram;
    });
}

void update(VoronoiDiagram& diagram, DiagramScene& scene, std::uint32_t number, const Object& object,
            const DiagramOptions& options) {
    if (number >= scene.objects.size())
        throw InputError(InputError::Kind::OutOfRange, number, "objects[" + std::to_string(number) + "]",
                         "is not there to be changed");
    const auto touched = [&](const whole::DecidedDiagram& decided) {
        std::vector<std::uint32_t> which;
        for (std::uint32_t i = 0; i < diagram.cells.size(); ++i)
            if (i == number || diagram.cells[i].state != DiagramCell::State::Computed ||
                decided.may_touch(number, i, diagram.cells[i].reach))
                which.push_back(i);
        return which;
    };
    std::vector<std::uint32_t> which = touched(whole::DecidedDiagram(scene));
    scene.objects[number] = object;
    const whole::DecidedDiagram decided(scene);
    const std::vector<std::uint32_t> after = touched(decided);
    which.insert(which.end(), after.begin(), after.end());
    std::ranges::sort(which);
    which.erase(std::ranges::unique(which).begin(), which.end());
    diagram.moved = std::max(diagram.moved, decided.moved());
    compute(decided, which, diagram, options);
}

ContactTable contacts(const VoronoiDiagram& diagram) {
    using Image = std::array<std::int16_t, 3>;
    struct Side {
        std::uint32_t first;
        Site second;
        Image image;
        std::uint32_t owner;  // whose cell has it
        const CellContact* contact;
    };
    std::vector<Side> sides;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i)
        for (const CellContact& c : diagram.cells[i].contacts) {
            Side side{i, c.site, c.image, i, &c};
            const Image back{static_cast<std::int16_t>(-c.image[0]), static_cast<std::int16_t>(-c.image[1]),
                             static_cast<std::int16_t>(-c.image[2])};
            if (c.site.is_object() && std::pair(c.site.index, c.image) < std::pair(i, back))
                side = {c.site.index, Site::object(i), back, i, &c};
            sides.push_back(side);
        }
    const auto key = [](const Side& s) { return std::tie(s.first, s.second, s.image); };
    std::ranges::sort(sides, [&](const Side& a, const Side& b) {
        return std::tuple_cat(key(a), std::tie(a.owner)) < std::tuple_cat(key(b), std::tie(b.owner));
    });

    ContactTable table;
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && key(sides[end]) == key(sides[i])) ++end;
        const Side& one = sides[i];
        const CellContact& c = *one.contact;
        Contact pair{one.first, one.second, one.image, c.faces, c.area, c.area_error};
        const std::string title =
            "objects " + name_of(one.first, {0, 0, 0}) + " and " +
            (one.second.is_object() ? name_of(one.second.index, one.image) : to_string(one.second));
        if (end - i > 1) {
            const CellContact& other = *sides[i + 1].contact;
            // What both enclose.
            const double low = std::max(c.area - c.area_error, other.area - other.area_error),
                         high = std::min(c.area + c.area_error, other.area + other.area_error);
            if (low > high || (c.faces != other.faces && c.faces != 0 && other.faces != 0)) {
                table.faults.push_back(title + ": the two cells do not have the same faces");
            } else {
                pair.area = 0.5 * low + 0.5 * high;
                pair.area_error = 0.5 * (high - low) + std::numeric_limits<double>::epsilon() * high;
            }
        } else if (one.second.is_object()) {
            const std::uint32_t other = one.owner == one.first ? one.second.index : one.first;
            const DiagramCell& cell = diagram.cells[other];
            const bool is_missed =
                cell.state == DiagramCell::State::Computed && !(c.area <= c.area_error) && !cell.is_estimated;
            if (is_missed)
                table.faults.push_back(title + ": only the cell of " + std::to_string(one.owner) +
                                       " has faces between them");
        }
        table.contacts.push_back(pair);
        i = end;
    }
    return table;
}

FilledVolume filled_volume(const DiagramScene& scene, const VoronoiDiagram& diagram) {
    FilledVolume sum;
    const Vec3 size = scene.box.max - scene.box.min;
    sum.box = size.prod();
    constexpr double u = std::numeric_limits<double>::epsilon();
    // The sides of a box in doubles, their product, and what periodic ones were moved by.
    sum.error = 4 * u * sum.box;
    for (int i = 0; i < 3; ++i)
        if (scene.periodic[i]) sum.error += 2 * diagram.moved * sum.box / size[i];
    for (const DiagramCell& cell : diagram.cells) {
        if (cell.state != DiagramCell::State::Computed) continue;
        sum.volume += cell.volume;
        sum.error += cell.volume_error;
        sum.is_estimated = sum.is_estimated || cell.is_estimated;
    }
    sum.error += u * static_cast<double>(diagram.cells.size()) * sum.volume;
    return sum;
}

}  // namespace vcell
