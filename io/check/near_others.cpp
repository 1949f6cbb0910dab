#include "near_others.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <variant>

#include "../../core/numbers/exact.hpp"
#include "../../envelope/whole/own_periods.hpp"
#include "../../primitives/objects/exact_space.hpp"
#include "space.hpp"

namespace vcell::check {

namespace {

// The axis of the box, among those that do not repeat, that a tube which does not close leaves it along.
int axis_of_ends(const DiagramScene& scene, const Cylinder& tube) {
    int across = -1;
    for (int k = 0; k < 3; ++k)
        if (!scene.periodic[static_cast<std::size_t>(k)] &&
            (across < 0 || std::abs(tube.axis[k]) > std::abs(tube.axis[across])))
            across = k;
    return across;
}

}  // namespace

NearOthers::NearOthers(const DiagramScene& scene, const NearBalls& balls)
    : scene_(scene), balls_(balls), periods_(scene.objects.size()) {
    if (!repeats()) return;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) find_periods(i);
}

void NearOthers::find_periods(std::uint32_t object) {
    const Object& o = scene_.objects[object];
    std::vector<ImageIndex>& periods = periods_[object];
    const auto* tube = std::get_if<Cylinder>(&o);
    if (std::holds_alternative<Sphere>(o)) return;
    if (tube == nullptr) {  // is the same after every edge, or is no part of a valid scene
        for (std::size_t k = 0; k < 3; ++k)
            if (scene_.periodic[k]) periods.emplace_back(ImageIndex{})[k] = 1;
        return;
    }
    // The shortest move that is exactly along the axis.
    constexpr int most = whole::most_edges_of_period;
    const Vec3 along = tube->axis.stableNormalized();
    const auto range = [&](std::size_t k) { return scene_.periodic[k] ? most : 0; };
    for (int a = -range(0); a <= range(0); ++a)
        for (int b = -range(1); b <= range(1); ++b)
            for (int c = -range(2); c <= range(2); ++c) {
                const ImageIndex image{static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                       static_cast<std::int16_t>(c)};
                const Vec3 by = balls_.shift(image);
                if (std::gcd(std::gcd(a, b), c) != 1 || !(by.dot(along) > 0) ||
                    by.cross(along).norm() > 0x1p-20 * by.norm())
                    continue;
                const auto exact = balls_.moved(Vec3::Zero(), image);
                if (exact && cross(ExactVector(*exact), ExactVector(tube->axis)).is_zero()) periods = {image};
            }
}

ImageIndex NearOthers::representative(const ObjectImage& image,
                                      std::optional<std::uint32_t> seen_from) const {
    std::vector<ImageIndex> both;
    if (seen_from) both = periods(*seen_from);
    const std::vector<ImageIndex>& own = periods(image.number);
    both.insert(both.end(), own.begin(), own.end());
    return whole::representative(image.image, both);
}

Box NearOthers::piece(const Cylinder& tube, std::uint32_t object, const Vec3& point, double reach) const {
    Vec3 begin = tube.point, end = tube.point;
    if (!periods_[object].empty()) {
        end += balls_.shift(periods_[object].front());
    } else {
        // What comes near to the point along the axis that it leaves the box by.
        const int across = axis_of_ends(scene_, tube);
        const Vec3 step = tube.axis / tube.axis[across];
        const Vec3 middle = tube.point + (point[across] - tube.point[across]) * step;
        begin = middle - 1.001 * reach * step;
        end = middle + 1.001 * reach * step;
    }
    const Vec3 rounding =
        Vec3::Constant(0x1p-40 * (begin.norm() + end.norm() + tube.point.norm() + point.norm()));
    return {begin.cwiseMin(end) - rounding, begin.cwiseMax(end) + rounding};
}

NearOthers::Search NearOthers::search(const Vec3& point, double reach) const {
    Search result;
    for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
        const Object& o = scene_.objects[i];
        if (std::holds_alternative<Sphere>(o)) continue;
        const auto* tube = std::get_if<Cylinder>(&o);
        if (tube == nullptr || !repeats()) {
            result.found.push_back({{i, {}}, o});
            continue;
        }
        std::vector<ImageIndex> images;
        const double far = 1.001 * (std::max(0.0, reach) + tube->radius);
        const bool are_all =
            balls_.for_images(piece(*tube, i, point, far), point, far, [&](const ImageIndex& image) {
                Cylinder moved = *tube;
                moved.point += balls_.shift(image);
                const Interval distance = Surface<Interval>(moved).distance(to_vector<Interval>(point));
                const double slack = 0x1p-40 * (moved.point.norm() + point.norm() + far);
                if (!(distance.lower() > reach + slack)) images.push_back(representative({i, image}));
            });
        if (!are_all) result.lack = "more images of tubes may reach it than are looked at";
        std::ranges::sort(images);
        images.erase(std::unique(images.begin(), images.end()), images.end());
        for (const ImageIndex& image : images) {
            const auto at = balls_.moved(tube->point, image);
            if (!at) result.lack = "where an image of a tube is that may reach it is no double";
            result.found.push_back(
                {{i, image}, Cylinder{at.value_or(tube->point), tube->axis, tube->radius}});
        }
    }
    return result;
}

std::optional<int> NearOthers::cut_of(const Cylinder& tube, std::uint32_t object) const {
    if (periods_[object].empty()) return std::nullopt;
    int across = 0;
    tube.axis.cwiseAbs().maxCoeff(&across);
    return across;
}

// The cell is its own image after a period, and with each of its points it has the way from there to the
// point's foot on the axis. Let it come to no sides of the box but those of the cut. Were one of its points
// in no image of the box by periods, its way to the axis, which is in them, would come into one through the
// plane of a cut beside the image before or after that: where the cell's sections with these planes are
// within both images it does not.
std::string NearOthers::lack_of_period(const Box& box, int cut, const ImageIndex& period,
                                       const std::vector<CellEdge>& edges) const {
    const auto by = balls_.moved(Vec3::Zero(), period);
    if (!by || (Exact(box.max[cut]) - Exact(box.min[cut]) - Exact(std::abs((*by)[cut]))).sign() != Sign::Zero)
        return "the cell's box is not as wide as the tube's period";
    const double sign = (*by)[cut] > 0 ? 1 : -1;
    for (const CellEdge& e : edges)
        for (const Site& site : e.sites) {
            if (site.kind != Site::Kind::BoxSide || static_cast<int>(site.index / 2) != cut) continue;
            const Vec3 next = (site.index % 2 == 0 ? sign : -sign) * *by;
            for (const auto& point : e.curve.points)
                for (int k = 0; k < 3; ++k) {
                    const double p = point[k] + next[k];
                    if (k != cut && scene_.periodic[static_cast<std::size_t>(k)] &&
                        !(p - e.error > box.min[k] && p + e.error < box.max[k]))
                        return "the cell's box does not hold its end after a period";
                }
        }
    return {};
}

// Holds the cell of a tube that leaves the box through sides that do not repeat: its own images leave to it,
// but for the axes that do not repeat, no point farther from the axis than half of a diagonal of the edges.
Box NearOthers::room(const Cylinder& tube) const {
    const auto repeats_along = [&](int k) { return scene_.periodic[static_cast<std::size_t>(k)]; };
    const int across = axis_of_ends(scene_, tube);
    Box box = scene_.box;
    const Vec3 step = tube.axis / tube.axis[across],
               middle = tube.point + (0.5 * (box.min[across] + box.max[across]) - tube.point[across]) * step;
    // Along one of the box's axes half of each edge does.
    const bool is_across = (step.array() != 0).count() == 1;
    double all = 0, beside = 0;
    for (int k = 0; k < 3; ++k) {
        ImageIndex one{};
        one[static_cast<std::size_t>(k)] = 1;
        if (repeats_along(k))
            all = std::hypot(all, 0.5 * balls_.shift(one).norm());
        else
            beside = std::hypot(beside,
                                std::max(std::abs(box.max[k] - middle[k]), std::abs(box.min[k] - middle[k])));
    }
    const double slope = step.cross(Vec3::Unit(across)).norm() / step.norm(),
                 far = 0.5 * (box.max[across] - box.min[across]) + slope * std::hypot(all, beside);
    for (int k = 0; k < 3; ++k) {
        if (!repeats_along(k)) continue;
        ImageIndex one{};
        one[static_cast<std::size_t>(k)] = 1;
        const double half = is_across ? 0.5 * balls_.shift(one).norm() : std::abs(step[k]) * far + all;
        box.min[k] = middle[k] - half;
        box.max[k] = middle[k] + half;
    }
    return box;
}

std::string NearOthers::lack_of_room(const Box& box, std::uint32_t object,
                                     const std::vector<CellEdge>& edges) const {
    const auto* tube = std::get_if<Cylinder>(&scene_.objects[object]);
    const auto width = [](const Box& of, int k) { return Exact(of.max[k]) - Exact(of.min[k]); };
    for (int k = 0; k < 3; ++k) {
        if (scene_.periodic[static_cast<std::size_t>(k)]) {
            if (tube == nullptr && (width(box, k) - width(scene_.box, k)).sign() != Sign::Zero)
                return "the cell's box is not as wide as the scene's";
        } else if (box.min[k] != scene_.box.min[k] || box.max[k] != scene_.box.max[k]) {
            return "the cell's box has other sides than the scene's, which does not repeat there";
        }
    }
    if (tube == nullptr) return {};
    if (const std::optional<int> cut = cut_of(*tube, object))
        return lack_of_period(box, *cut, periods_[object].front(), edges);
    const Box least = room(*tube);
    if ((box.min.array() > least.min.array()).any() || (box.max.array() < least.max.array()).any())
        return "the cell may be larger than its box";
    return {};
}

}  // namespace vcell::check
