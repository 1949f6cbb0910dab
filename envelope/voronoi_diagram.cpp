#include "voronoi_diagram.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "../core/errors.hpp"
#include "../core/platform.hpp"
#include "../core/threads.hpp"
#include "whole/ball_cell.hpp"
#include "whole/body_volume.hpp"
#include "whole/cell_finder.hpp"
#include "whole/complete_cells.hpp"
#include "whole/totals.hpp"

namespace vcell {

namespace {

// Some cells at a time are held for `visit`, which has them in order.
constexpr std::size_t cells_at_a_time = 256;

// Objects that cut each other too deep for cells are solid all the same; others lie in these, or are walls.
bool has_body(const DiagramCell& cell) {
    return cell.state != DiagramCell::State::Empty && cell.state != DiagramCell::State::Wall;
}

// What cannot be told stays not_measured.
void add_body(const whole::DecidedDiagram& decided, std::uint32_t object, DiagramCell& cell) {
    if (!has_body(cell)) return;
    try {
        const whole::BodyVolume body = whole::body_volume(decided, object);
        cell.body_volume = body.volume;
        cell.body_error = body.error;
        cell.body_estimated = body.is_estimated;
    } catch (const UndecidedError&) {
    } catch (const InputError&) {
    }
}

void compute(const whole::DecidedDiagram& decided, const std::vector<std::uint32_t>& which,
             VoronoiDiagram& diagram, const DiagramOptions& options) {
    const unsigned threads = thread_count(options.threads);
    for (std::size_t begin = 0; begin < which.size(); begin += cells_at_a_time) {
        const std::size_t count = std::min(cells_at_a_time, which.size() - begin);
        std::vector<std::vector<Cell>> cells(options.visit ? count : 0);
        for_all(count, threads, [&](std::size_t i) {
            const std::uint32_t object = which[begin + i];
            if (options.visit && (options.complete || decided.is_ball(object))) {
                whole::WholeCells found = whole::find_whole_cells(decided, object);
                diagram.cells[object] = std::move(found.measured);
                cells[i] = std::move(found.cells);
            } else {
                diagram.cells[object] = whole::find_cell(decided, object, nullptr);
            }
            if (options.bodies) add_body(decided, object, diagram.cells[object]);
        });
        for (std::size_t i = 0; i < cells.size(); ++i)
            for (const Cell& cell : cells[i]) options.visit(which[begin + i], cell);
        if (options.progress)
            options.progress(static_cast<double>(begin + count) / static_cast<double>(which.size()));
    }
}

// All cells of a diagram that is simple, each face in one of its two: those of balls that lie together after
// each other.
void compute_sharing(const whole::DecidedDiagram& decided, VoronoiDiagram& diagram,
                     const DiagramOptions& options) {
    const unsigned threads = thread_count(options.threads);
    const std::vector<BallTree::Leaf> leaves = decided.balls().tree().leaves();
    std::vector<whole::SharedParts> shared(diagram.cells.size());
    constexpr std::size_t leaves_at_a_time = 64;
    for (std::size_t begin = 0; begin < leaves.size(); begin += leaves_at_a_time) {
        const std::size_t count = std::min(leaves_at_a_time, leaves.size() - begin);
        for_all(count, threads, [&](std::size_t i) {
            const BallTree::Leaf& leaf = leaves[begin + i];
            const whole::Neighborhood around(decided, leaf);
            for (const BallTree::Entry& e : leaf.balls) {
                whole::FoundCell found = whole::find_sharing_cell(decided, e.number, around);
                diagram.cells[e.number] = std::move(found.cell);
                shared[e.number] = std::move(found.shared);
            }
        });
        if (options.progress)
            options.progress(static_cast<double>(begin + count) / static_cast<double>(leaves.size()));
    }
    const std::vector<std::uint32_t> lacking = whole::share_faces(diagram.cells, shared);
    for_all(lacking.size(), threads, [&](std::size_t i) {
        if (!whole::complete_ball_cell(decided, lacking[i], diagram.cells[lacking[i]]))
            diagram.cells[lacking[i]] = whole::find_cell(decided, lacking[i], nullptr);
    });
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i)
        if (!decided.hidden(i).empty()) diagram.cells[i] = whole::find_cell(decided, i, nullptr);
    if (options.bodies)
        for_all(diagram.cells.size(), threads,
                [&](std::size_t i) { add_body(decided, static_cast<std::uint32_t>(i), diagram.cells[i]); });
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
        diagram.periods = decided.all_periods();
        diagram.cells.resize(scene.objects.size());
        if (decided.is_simple() && !options.visit) {
            compute_sharing(decided, diagram, options);
            return diagram;
        }
        std::vector<std::uint32_t> all(scene.objects.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
        compute(decided, all, diagram, options);
        return diagram;
    });
}

namespace {

// Where the box repeats all is moved to a grid as coarse as the farthest object asks for. Is it where it was,
// but for an object that has changed?
bool are_on_one_grid(const DiagramScene& before, const DiagramScene& after, std::uint32_t changed) {
    if (!before.is_periodic()) return true;
    for (std::uint32_t i = 0; i < before.objects.size(); ++i)
        if (i != changed && before.objects[i] != after.objects[i]) return false;
    return before.tilt == after.tilt && before.box.min == after.box.min && before.box.max == after.box.max;
}

}  // namespace

void update(VoronoiDiagram& diagram, DiagramScene& scene, std::uint32_t number, const Object& object,
            const DiagramOptions& options) {
    if (number >= scene.objects.size())
        throw InputError(InputError::Kind::OutOfRange, number, "objects[" + std::to_string(number) + "]",
                         "is not there to be changed");
    DiagramScene changed = scene;
    changed.objects[number] = object;
    const whole::DecidedDiagram before(scene), decided(changed);
    std::vector<std::uint32_t> which;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        if (i == number || cell.state != DiagramCell::State::Computed ||
            before.may_touch(number, i, cell.reach) || decided.may_touch(number, i, cell.reach))
            which.push_back(i);
    }
    if (!are_on_one_grid(before.scene(), decided.scene(), number)) {
        which.resize(diagram.cells.size());
        std::iota(which.begin(), which.end(), 0u);
    }
    scene = std::move(changed);
    diagram.moved = std::max(diagram.moved, decided.moved());
    diagram.periods = decided.all_periods();
    compute(decided, which, diagram, options);
}

ContactTable contacts(const VoronoiDiagram& diagram) {
    std::vector<whole::ContactSide> sides;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i)
        for (const CellContact& c : diagram.cells[i].contacts)
            sides.push_back(whole::contact_side(i, c, diagram.periods));
    return whole::pair_up(std::move(sides),
                          [&](std::uint32_t i) { return whole::knows_contacts(diagram.cells[i]); });
}

FilledVolume filled_volume(const DiagramScene& scene, const VoronoiDiagram& diagram) {
    whole::VolumeSum sum(scene, diagram.moved);
    sum.add(diagram.cells);
    return sum.of(diagram.cells.size());
}

FilledVolume body_volume(const DiagramScene& scene, const VoronoiDiagram& diagram) {
    FilledVolume sum = whole::VolumeSum(scene, diagram.moved).of(0);
    for (const DiagramCell& cell : diagram.cells) {
        if (!has_body(cell)) continue;
        sum.volume += cell.body_volume;
        sum.error += cell.body_error;
        sum.is_estimated = sum.is_estimated || cell.body_estimated;
    }
    sum.error +=
        std::numeric_limits<double>::epsilon() * static_cast<double>(diagram.cells.size()) * sum.volume;
    return sum;
}

}  // namespace vcell
