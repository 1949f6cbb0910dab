#include "judged_patch.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "excess.hpp"
#include "least_slope.hpp"

namespace vcell::check {
namespace {

class PatchDistance : public Room {
public:
    PatchDistance(const JudgedPatch& judged, const Subject& subject, const CheckOptions& options,
                  Certificate& certificate)
        : Room(subject, options, certificate), judged_(judged) {}

    std::optional<double> follow(const std::optional<double>& boundary) {
        const Patch& patch = judged_.patch;
        if (judged_.spheres)
            if (const auto near = nearness_by_spheres(*judged_.spheres);
                near && near->distance && near->size <= judged_.width &&
                (!near->is_bent || *near->distance <= boundary.value_or(0)))
                return near->distance;
        if (boundary)
            if (const auto distance = distance_inside(*boundary)) return distance;
        std::vector<Tile> tiles;
        tiles.push_back(judged_.whole);
        double most = 0;
        std::size_t count = 0;
        while (!tiles.empty()) {
            Tile tile = std::move(tiles.back());
            tiles.pop_back();
            const Nearness near = nearness(tile, count == 0);
            const bool is_rounding = 2 * near.size > std::exchange(tile.excess, near.size);
            const bool is_told = !near.is_bent || tile.depth >= kBent;
            if (const double to_tip = farthest_from(judged_.tips, tile.net.box()); to_tip <= most_stated(0)) {
                most = std::max(most, to_tip);
                continue;
            }
            if (near.distance &&
                ((near.size <= judged_.width && is_told) || *near.distance <= boundary.value_or(0) ||
                 (is_rounding && near.size <= judged_.stated))) {
                most = std::max(most, *near.distance);
                continue;
            }
            if (is_outside(patch, tile)) continue;
            if (const auto e = off_bisector(tile)) {
                certificate_.refute(judged_.where,
                                    fmt::format("{} is {:.3g} {} than the base", title(judged_.own[0].site),
                                                std::abs(*e), *e < 0 ? "nearer" : "farther"),
                                    0.5 * std::abs(*e));
                return std::nullopt;
            }
            if (++count > tiles_allowed(options_)) {
                certificate_.leave_open(judged_.where,
                                        fmt::format("its site's excess is below {:.3g}", near.size),
                                        near.distance.value_or(HUGE_VAL));
                return std::nullopt;
            }
            for (Tile& half : tile.halves(tile.longer_axis_of_sides())) tiles.push_back(std::move(half));
        }
        return most;
    }

private:
    /// Bounds of the own sites' excesses all over a tile, and of how far it is from the bisector then.
    struct Nearness {
        double size;
        std::optional<double> distance;
        bool is_bent = false;  // halves may tell the distance better
    };
    struct Reach {
        double distance;
    };
    /// Halvings after which a tile is taken as it is.
    static constexpr int kBent = 4;
    Nearness nearness(const Tile& tile, bool is_whole) const {
        // Tiles that are many times smaller are few, where gradients all but vanish: forms know of places.
        constexpr int most_depth = 6, least_depth_of_forms = 4;
        // A wall's excess grows by one per length, and of a side of the box it is a coordinate.
        if (judged_.own.size() == 1 && !judged_.own[0].is_of_object()) {
            const Condition& wall = judged_.own[0];
            const double size = magnitude(wall.wall ? ExcessAlong(space(), tile.net).excess(wall)
                                                    : space().excess(wall, tile.net.box()))
                                    .upper();
            return {size, size};
        }
        if (tile.depth <= most_depth) {
            const auto part =
                is_whole ? judged_.spheres : TouchingSpheres::on(tile.net, judged_.own[0].site, space());
            if (const auto near = part ? nearness_by_spheres(*part) : std::nullopt) return *near;
            // They cost as much as several halves.
            if (is_of_spheres() && tile.depth < least_depth_of_forms) return {HUGE_VAL, std::nullopt};
        }
        const ExcessAlong along(space(), tile.net);
        if (const auto distance = distance_from_twin(along, tile.net);
            distance && 2 * *distance <= judged_.width)
            return {2 * *distance, distance};
        double size = 0;
        for (const Condition& c : judged_.own) size = std::max(size, magnitude(along.excess(c)).upper());
        return {size, distance(tile.net, size)};
    }
    /// By the difference of squares, whose gradient is twice what an object and a base like it are apart,
    /// even between their axes, where that of distances turns around. Excesses are no more than twice that.
    std::optional<double> distance_from_twin(const ExcessAlong& along, const Net& net) const {
        if (judged_.own.size() > 1 || !judged_.own[0].is_of_object()) return std::nullopt;
        const std::uint32_t twin = judged_.own[0].site.index;
        const auto squares = along.squares_of_twin(twin);
        if (!squares) return std::nullopt;
        const Interval size = magnitude(*squares);
        const auto reach = within_margin(
            [&](double margin) -> std::optional<Reach> {
                const auto apart = space().apart_from_twin(twin, box_about(net.box(), margin));
                const Interval slope = apart ? Interval(2.0) * sqrt(square(*apart)) : Interval(0.0);
                if (!(slope.lower() > 0)) return std::nullopt;
                return Reach{(size / slope).upper()};
            },
            0);
        return reach ? std::optional(reach->distance) : std::nullopt;
    }
    /// Is the bisector one of a ball and a ball or a plane?
    bool is_of_spheres() const {
        const auto is_tube = [](const Object& o) { return std::holds_alternative<Cylinder>(o); };
        return std::holds_alternative<Sphere>(scene_.base) && judged_.own[0].site.is_object() &&
               !is_tube(scene_.objects[judged_.own[0].site.index]);
    }
    /// None: it takes forms to tell.
    std::optional<Nearness> nearness_by_spheres(const TouchingSpheres& spheres) const {
        double size = 0;
        for (const Condition& c : judged_.own) {
            const auto e = spheres.excess(c);
            if (!e) return std::nullopt;
            size = std::max(size, magnitude(*e).upper());
        }
        if (!(size < HUGE_VAL)) return std::nullopt;
        return Nearness{size, distance_by_spheres(spheres, size), spheres.is_bent()};
    }
    std::optional<double> distance_by_spheres(const TouchingSpheres& spheres, double size) const {
        return distance_where(
            [&](double margin) -> std::optional<double> {
                if (!judged_.own[0].site.is_object()) return 1.0;
                const auto growth = spheres.growth(judged_.own[0].site, size, margin);
                return growth ? std::optional(sqrt(Interval(2.0) * *growth).lower()) : std::nullopt;
            },
            size);
    }
    /// Inside the loops, which lift to within `boundary` of their edges. None: it takes tiles to tell.
    std::optional<double> distance_inside(double boundary) const {
        const auto* base = std::get_if<Sphere>(&scene_.base);
        if (!base || judged_.own.size() > 1) return std::nullopt;
        double reach = 0;
        for (const auto& loop : judged_.patch.loops)
            for (const Trim& trim : loop) {
                if (!trim.curve->edge) return std::nullopt;
                for (const auto& piece : edge_pieces_[*trim.curve->edge])
                    for (std::size_t i = 0; i < piece.points.size(); ++i)
                        reach = std::max(reach, (piece.control(i) - base->center).norm());
            }
        const auto inside = TouchingSpheres::inside(judged_.whole.net, judged_.own[0].site, space(),
                                                    (reach + boundary) * (1 + 0x1p-40));
        if (!inside || !(inside->excess <= judged_.width)) return std::nullopt;
        return distance_by_spheres(inside->spheres, inside->excess);
    }
    /// How far from the bisector a point with that excess may be: size / s where the gradient is at least s
    /// on the way there, along which the excess only falls.
    std::optional<double> distance(const Net& net, double size) const {
        return distance_where(
            [&](double margin) -> std::optional<double> {
                const Vector<Interval> around = box_about(net.box(), margin);
                const double slope = sqrt(square(space().gradient(judged_.own[0], around))).lower();
                if (slope > 0 || !judged_.own[0].site.is_object()) return slope;
                const double least = least_slope(space(), judged_.own[0].site.index, net, margin, size);
                return least * most_distance() >= size ? least : 0;
            },
            size);
    }
    /// A bound above that says nothing of short gradients: no edge may be farther away, either.
    double most_distance() const { return 256 * scene_tolerance(); }
    /// How far that is where the gradient's least length within a margin is known.
    template <class Slope>
    static std::optional<double> distance_where(const Slope& slope_within, double size) {
        const auto reach = within_margin(
            [&](double margin) -> std::optional<Reach> {
                const std::optional<double> slope = slope_within(margin);
                if (!slope || !(*slope > 0)) return std::nullopt;
                return Reach{(Interval(size) / *slope).upper()};
            },
            size);
        return reach ? std::optional(reach->distance) : std::nullopt;
    }
    std::optional<double> off_bisector(const Tile& tile) const {
        const Patch& patch = judged_.patch;
        for (const int i : {0, 1})
            for (const int j : {0, 1})
                for (const Condition& c : judged_.own) {
                    const Interval e = space().excess(c, tile.net.corner(i, j));
                    const Vec2 uv(i == 0 ? tile.lo.x() : tile.hi.x(), j == 0 ? tile.lo.y() : tile.hi.y());
                    const double allowed = 2 * std::max(judged_.width, judged_.stated);
                    if (!(magnitude(e).lower() > allowed)) continue;
                    const auto is_inside = inside(patch, uv, rounding());
                    // Excesses change by twice the distance at most: from inside the loops to what is near
                    // them.
                    const SurfacePoint s = lift(patch, uv);
                    const Vec2 near = kNearEdge * (patch.hi - patch.lo);
                    const double reach = near.x() * s.pu.norm() + near.y() * s.pv.norm();
                    if (is_inside.value_or(magnitude(e).lower() > allowed + 4 * reach)) return e.mid();
                }
        return std::nullopt;
    }

    const JudgedPatch& judged_;
};

}  // namespace

std::optional<double> certify_on_bisector(const JudgedPatch& judged, const std::optional<double>& boundary,
                                          const Subject& subject, const CheckOptions& options,
                                          Certificate& certificate) {
    return PatchDistance(judged, subject, options, certificate).follow(boundary);
}

}  // namespace vcell::check
