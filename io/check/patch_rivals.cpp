#include "judged_patch.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "tangents.hpp"
#include "turns.hpp"

namespace vcell::check {
namespace {

class PatchRivals : public Room {
public:
    PatchRivals(const JudgedPatch& judged, double margin, const Subject& subject, const CheckOptions& options,
                Certificate& certificate)
        : Room(subject, options, certificate), judged_(judged), margin_(margin) {
        // Where both are as near and the same way off they touch, the one within the other.
        const Site& site = judged.own[0].site;
        is_apart_ = site.is_object() && gap(scene_.objects[site.index]) > 0;
        is_own_twin_ = is_twin(judged.own[0]);
    }

    /// False where a rival is nearer, or may be.
    bool exclude() {
        const Patch& patch = judged_.patch;
        auto found = rivals();
        if (found.empty()) return true;
        std::vector<Tile> tiles;
        tiles.push_back(judged_.whole);
        tiles.back().rivals = std::move(found);
        std::size_t count = 0;
        bool are_held_dropped = false;
        while (!tiles.empty()) {
            if (count > kFew && !std::exchange(are_held_dropped, true))
                for (Tile& t : tiles)
                    std::erase_if(t.rivals,
                                  [&](const Rival& r) { return is_held(r.condition.site, judged_.own); });
            Tile tile = std::move(tiles.back());
            tiles.pop_back();
            drop(tile, count);
            if (tile.rivals.empty() || is_outside(patch, tile)) continue;
            // Where a rival is nearer tiles become ever smaller: few of them need be asked.
            constexpr int every = 4;
            const Vec2 uv = 0.5 * (tile.lo + tile.hi);
            const auto nearer =
                tile.depth % every == every - 1 ? nearer_at(lift(patch, uv).p, tile.rivals) : std::nullopt;
            if (nearer && inside(patch, uv, rounding()).value_or(false)) {
                certificate_.refute(judged_.where,
                                    fmt::format("{} is {:.3g} nearer than the base",
                                                title(nearer->first.site), nearer->second),
                                    nearer->second);
                return false;
            }
            if (++count > kMoreTiles * tiles_allowed(options_)) {
                certificate_.leave_open(
                    judged_.where,
                    fmt::format("{} may be nearer somewhere", title(tile.rivals[0].condition.site)),
                    HUGE_VAL);
                return false;
            }
            for (Tile& half : tile.halves(tile.longer_axis())) tiles.push_back(std::move(half));
        }
        return true;
    }

private:
    /// Beside edges of nearly parallel bisectors tiles become many, but rivals few.
    static constexpr std::size_t kMoreTiles = 4;
    /// Tiles after which the patch is taken to have places where bisectors touch.
    static constexpr std::size_t kFew = 64;
    /// Tiles after which rivals are told by tangents, too: some are least all along a line.
    static constexpr std::size_t kMany = 1024;
    bool is_twin(const Condition& c) const {
        return c.is_of_object() && space().is_twin_of_base(c.site.index);
    }
    /// A lower bound of how far an object is from the base; of little use unless one of them is a ball, and
    /// the other none but a plane, a ball or a tube.
    double gap(const Object& object) const {
        const auto from = [&](const Object& o, const Sphere& ball, bool is_base) {
            const Slope s = slope_within(o, ball.center, 0, is_base);
            return s.distance - s.rounding - (1 + kRough) * ball.radius;
        };
        if (const auto* ball = std::get_if<Sphere>(&object)) return from(scene_.base, *ball, true);
        const auto* base = std::get_if<Sphere>(&scene_.base);
        return base ? from(object, *base, false) : -HUGE_VAL;
    }
    /// An upper bound of the excess, where it is negative, at places from which the base and the object are
    /// the same way. One is a ball: its centre is on that way, and behind it the other's surface, so that the
    /// excess is their distance and the object's diameter, taken away. Infinite where the object is not away
    /// from the base: the one may hold the other then.
    double excess_behind(std::uint32_t i) const {
        const Object& object = scene_.objects[i];
        const double away = gap(object);
        if (!(away > 0)) return HUGE_VAL;
        // The wall of a vessel is behind the base then, and farther than it by all of that and its diameter.
        if (is_vessel(object)) return -HUGE_VAL;
        const auto* ball = std::get_if<Sphere>(&object);
        const auto* tube = std::get_if<Cylinder>(&object);
        const double radius = ball ? ball->radius : tube ? tube->radius : 0;
        return -(away + 2 * radius) * (1 - kRough);
    }
    std::vector<Rival> rivals() const {
        const Vector<Interval>& box = judged_.whole.net.box();
        const auto ball = [&](const Condition& c) {
            return c.site.is_object() ? std::get_if<Sphere>(&scene_.objects[c.site.index]) : nullptr;
        };
        const Sphere* own = ball(judged_.own[0]);
        std::optional<LeastPlacesOfSites> least;
        std::vector<Rival> found;
        const Interval clearance = judged_.spheres ? judged_.spheres->clearance() : space().clearance(box);
        const auto* base = std::get_if<Sphere>(&scene_.base);
        const Vec3 center = middle(box);
        const double reach = (Interval(radius(box)) + Interval(margin_)).upper();
        std::vector<Condition> conditions;
        Room::rivals(center, (clearance + Interval(reach)).upper(), judged_.own, conditions);
        for (const Condition& c : conditions) {
            if (is_beside(c, box)) continue;
            const Sphere* rival = ball(c);
            // In the order of what they take.
            if (judged_.spheres && rival && own && !judged_.spheres->may_be_least(*own, *rival, margin_))
                continue;
            if (base && rival && own && LeastPlaces::do_rays_miss(*base, *own, *rival, center, reach))
                continue;
            if (judged_.spheres && judged_.spheres->is_farther(c.site, margin_)) continue;
            if (!least) least.emplace(scene_, judged_.own[0].site);
            const auto spots = least->of(c.site, 2 * judged_.stated + tie_width(c.site));
            if (spots && spots->empty()) continue;
            found.push_back({c, spots});
        }
        return found;
    }
    /// Is it a side of the box that a tile lies inside of?
    bool is_beside(const Condition& c, const Vector<Interval>& box) const {
        return (c.site.kind == Site::Kind::BoxSide || c.wall) && space().excess(c, box).lower() >= margin_;
    }
    /// Drops the rivals that need not be looked for in a tile.
    void drop(Tile& tile, std::size_t count) const {
        const Vector<Interval>& box = tile.net.box();
        const auto is_elsewhere = [&](const Spot& spot) {
            const double reach = Interval::up(spot.radius + margin_);
            for (std::size_t k = 0; k < 3; ++k) {
                const double at = spot.center[static_cast<Eigen::Index>(k)];
                if (Interval::up(at + reach) < box[k].lower() || Interval::down(at - reach) > box[k].upper())
                    return true;
            }
            return tile.misses(spot.center, reach);
        };
        std::erase_if(tile.rivals, [&](const Rival& rival) {
            if (is_beside(rival.condition, box)) return true;
            if (!rival.spots) return false;
            if (std::ranges::all_of(*rival.spots, is_elsewhere)) return true;
            // A least value that is not negative is as good as none.
            return tile.depth == 0 && std::ranges::all_of(*rival.spots, [&](const Spot& spot) {
                       const Vector<Interval> place = box_about(spot.center, spot.radius);
                       return is_elsewhere(spot) || space().excess(rival.condition, place).lower() >= 0;
                   });
        });
        // Where places are told far better than the tile its halves tell more than gradients, which are
        // parallel there. Beside the loops a place may stay in all halves.
        constexpr double far_better = 0x1p-4;
        constexpr int most_depth = 16;
        const double size = (tile.net.about(0, 0) - tile.net.about(1, 1)).norm();
        const auto is_told = [&](const Rival& rival) {
            return tile.depth < most_depth && rival.spots &&
                   std::ranges::all_of(*rival.spots, [&](const Spot& spot) {
                       return spot.radius + margin_ <= far_better * size;
                   });
        };
        if (std::ranges::all_of(tile.rivals, is_told)) return;
        const Test test(*this, tile.net, count);
        std::erase_if(tile.rivals,
                      [&](const Rival& rival) { return !is_told(rival) && test(rival.condition); });
    }
    /// A rival that is nearer at p by more than rounding.
    std::optional<std::pair<Condition, double>> nearer_at(const Vec3& p,
                                                          std::span<const Rival> rivals) const {
        for (const auto& [c, spots] : rivals)
            if (const Interval e = space().excess(c, to_vector<Interval>(p));
                e.upper() < -2 * judged_.width - tie_width(c.site))
                return std::pair(c, -e.upper());
        return std::nullopt;
    }

    /// Need a rival not be looked for in a tile? It is nowhere nearer there, or its excess has no least value
    /// there on the bisector.
    class Test {
    public:
        Test(const PatchRivals& room, const Net& net, std::size_t count)
            : room_(room), scene_(room.scene_), net_(net), box_(net.box()), count_(count) {
            center_ = middle(box_);
            radius_ = radius(box_) + room.margin_;  // the bisector itself, too
            base_ = slope_within(scene_.base, center_, radius_, true);
            own_ = slope(room.judged_.own[0]);
        }

        bool operator()(const Condition& c) const {
            if (c.site.is_object() &&
                room_.space().is_beyond(c.site.index, center_, base_.distance + base_.rounding + 2 * radius_))
                return true;
            const Slope rival = slope(c);
            const double rounding = rival.rounding + (c.is_of_object() ? base_.rounding : 0);
            const double steepest = rival.direction.norm() + rival.turn + kRough;
            if (rival.distance - rounding >= (1 + kRough) * steepest * radius_) return true;
            if (is_nowhere_parallel(c, rival, rival.distance - rounding - (1 + kRough) * steepest * radius_))
                return true;
            const bool alike = room_.space().are_alike(c, room_.judged_.own[0]);
            if (alike ? are_apart(c) : (room_.is_own_twin_ || room_.is_twin(c)) && are_across(c)) return true;
            if ((alike && is_farther(c, true)) || (count_ > kFew && is_farther(c, false))) return true;
            return count_ > kMany && least_by_tangents(room_.space(), c, net_) >= -room_.tie_width(c.site);
        }

    private:
        /// The excess and its gradient.
        Slope slope(const Condition& c) const {
            if (!c.is_of_object()) {
                const Interval e = room_.space().excess(c, to_vector<Interval>(center_));
                return {e.mid(), e.radius(), middle(room_.space().gradient(c, box_)), kRough};
            }
            const Object& object = scene_.objects[c.site.index];
            // The distance from a plane that has the base on one side is signed, so it has no kink in the
            // plane.
            const bool is_sided = room_.space().is_sided(c.site.index);
            Slope s = slope_within(object, center_, radius_, is_sided);
            if (is_sided && s.direction.dot(middle(room_.space().object(c.site.index).direction)) < 0) {
                s.distance = -s.distance;
                s.direction = -s.direction;
            }
            return {s.distance - base_.distance, s.rounding, s.direction - base_.direction,
                    s.turn + base_.turn};
        }

        /// Is the rival's gradient nowhere parallel to the own one on the bisector within the tile, where its
        /// excess, which is no less than `least`, is negative?
        ///
        /// An object's gradient is n - u, with unit vectors n and u. A line meets the unit sphere in two
        /// points: n - u is parallel to another object's n' - u where n = u or n = n', and to the gradient m
        /// of a side where n = u or n is u reflected in the plane across m.
        bool is_nowhere_parallel(const Condition& c, const Slope& rival, double least) const {
            const bool is_object = c.is_of_object(), is_own_object = room_.judged_.own[0].is_of_object();
            const Vec3 &g = rival.direction, &h = own_.direction, &u = base_.direction;
            if (!is_object && !is_own_object) return g.cross(h).norm() > 4 * kRough;
            const auto differ = [](const Vec3& way, double turn) {
                return way.norm() > (1 + kRough) * turn + 4 * kRough;
            };
            if (is_own_object && !room_.is_apart_ && !differ(h, own_.turn)) return false;
            if (is_object && !differ(g, rival.turn) && !(least > room_.excess_behind(c.site.index)))
                return false;
            // What the one gradient needs to be, less what it is.
            if (is_object && is_own_object) return differ(g - h, rival.turn + own_.turn - 2 * base_.turn);
            const auto reflected = [&](const Vec3& m) { return -2 * m.dot(u) * m; };
            return is_object ? differ(g - reflected(h), rival.turn) : differ(h - reflected(g), own_.turn);
        }

        /// Own and rival are of one kind: their gradients may differ by little, but the difference is known
        /// well.
        bool are_apart(const Condition& c) const {
            const Vector<Interval> around = box_about(center_, radius_);
            return square(cross(room_.space().gradient(c, around),
                                room_.space().gradient_difference(room_.judged_.own[0], c, around)))
                       .lower() > 0;
        }

        /// Is one of two gradients, which is as small as what lies between the base and its twin, and known
        /// to a part of that, nowhere parallel to the other one?
        bool are_across(const Condition& c) const {
            const Vector<Interval> around = box_about(center_, radius_);
            return square(cross(room_.space().gradient(c, around),
                                room_.space().gradient(room_.judged_.own[0], around)))
                       .lower() > 0;
        }

        /// Where bisectors touch, the excess changes slowly on the patch. Of objects of one kind the
        /// difference of the excesses does, which is the rival's where the own one is 0, on the bisector.
        bool is_farther(const Condition& c, bool alike) const {
            const Space<Interval>& space = room_.space();
            const Condition& own = room_.judged_.own[0];
            const Vector<Interval> gradient =
                alike ? space.gradient_difference(c, own, box_) : space.gradient(c, box_);
            const Changes& known = changes();
            const Interval change =
                magnitude(dot(gradient, known.slopes[0])) + magnitude(dot(gradient, known.slopes[1]));
            Interval excess = space.excess(c, known.corner);
            if (alike) excess = excess - space.excess(own, known.corner);
            return (excess - change).lower() >= -room_.tie_width(c.site);
        }

        /// How the tile's points change along both parameters, from a corner on. It is the same for all
        /// rivals, and found once for that.
        struct Changes {
            std::array<Vector<Interval>, 2> slopes;
            Vector<Interval> corner;
        };
        const Changes& changes() const {
            if (!changes_) changes_ = Changes{{net_.derivative(0), net_.derivative(1)}, net_.corner(0, 0)};
            return *changes_;
        }

        const PatchRivals& room_;
        const Scene& scene_;
        const Net& net_;
        Vector<Interval> box_;
        Vec3 center_;
        double radius_;
        Slope base_, own_;
        std::size_t count_;                       // of tiles so far
        mutable std::optional<Changes> changes_;  // made where they are asked for
    };

    const JudgedPatch& judged_;
    double margin_;  // how far the patch is from its bisector
    bool is_apart_;  // the base and the own object are surely two bodies
    bool is_own_twin_;
};

}  // namespace

bool certify_no_rivals(const JudgedPatch& judged, double margin, const Subject& subject,
                       const CheckOptions& options, Certificate& certificate) {
    return PatchRivals(judged, margin, subject, options, certificate).exclude();
}

}  // namespace vcell::check
