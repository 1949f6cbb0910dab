#include "faces.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "excess.hpp"
#include "least_slope.hpp"
#include "tangents.hpp"
#include "tile.hpp"
#include "tips.hpp"
#include "touching_spheres.hpp"
#include "trim_curves.hpp"
#include "turns.hpp"

namespace vcell::check {
namespace {

class Faces : public Room {
public:
    Faces(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
          Certificate& certificate)
        : Room(subject, options, certificate), edge_bounds_(edges) {}

    void run() {
        for (const std::uint32_t f : subject_.faces) check_name(f);
        for (const Patch& patch : patches_) judge(patch);
    }

private:
    void check_name(std::size_t f) {
        const CellFace& face = cell_.faces[f];
        const auto names = geometry_.bisector_names(face.site);
        if (std::ranges::find(names, face.bisector) == names.end())
            note(face_path(f) + ".bisector", fmt::format("is \"{}\", of the base and {} it is \"{}\"",
                                                         face.bisector, title(face.site), names[0]));
    }

    void judge(const Patch& patch) {
        std::string where = patch_path(patch.face, patch.index);
        const CellFace& face = cell_.faces[patch.face];
        own_.clear();
        own_.push_back({face.site});
        for (const Site& s : face.extra_sites) own_.push_back({s});
        // Where both are as near and the same way off they touch, the one within the other.
        is_apart_ = face.site.is_object() && gap(scene_.objects[face.site.index]) > 0;
        width_ = std::max(tie_width(face.site), kRounding * patch.control_size);
        stated_ = 0;
        tips_.clear();
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop) {
                if (trim.curve->edge) stated_ = std::max(stated_, full_error(*trim.curve->edge));
                if (trim.curve->is_tip() && face.site.is_object())
                    tips_ = tips_of(space(), scene_.objects[face.site.index]);
            }
        // What is more is refuted at the edge. Towards a tip rounding is divided by less and less.
        stated_ = std::min(stated_, most_stated(0));
        if (!tips_.empty()) stated_ = std::max(stated_, scene_tolerance());

        const Vec3 center = lift(patch, 0.5 * (patch.lo + patch.hi)).p;
        const Tile whole{net_over(*patch.surface, patch.lo, patch.hi, center), patch.lo, patch.hi, {}};
        spheres_ = TouchingSpheres::on(whole.net, face.site, space());
        if (spheres_) spheres_->refer_to(face.site);
        const auto boundary = check_boundary(patch, whole.net);
        const auto distance = follow_bisector(where, patch, whole, boundary);
        if (!distance) return;
        margin_ = std::max(width_, *distance);
        if (!exclude_others(where, patch, whole) || !boundary) return;
        prove(std::move(where), std::max(*distance, *boundary));
    }

    /// How far points between the trimming curves and the true arcs are from the true boundary; none where a
    /// curve or its edge is not proved. The excess of the site across the edge may be negative there, but no
    /// more than on the trimming curve, and it grows towards the base.
    std::optional<double> check_boundary(const Patch& patch, const Net& net) {
        double most = 0, widest = 0;
        bool proved = true;
        for (std::size_t l = 0; l < patch.loops.size(); ++l)
            for (std::size_t t = 0; t < patch.loops[l].size(); ++t) {
                const Trim& trim = patch.loops[l][t];
                if (!trim.curve->edge) continue;
                const TrimPlace place{l, t};
                const EdgeBound& edge = edge_bounds_[*trim.curve->edge];
                const double gap = certify_trim(patch, net, place, subject_, options_, certificate_,
                                                std::max(widest, 0.25 * edge.excess));
                widest = std::max(widest, gap);
                proved = proved && gap < HUGE_VAL && edge.growth > 0;
                most = std::max({most, gap, (edge.excess + 2 * gap) / edge.growth});
            }
        // Both are in the box.
        return proved ? std::optional(std::min(most, scene_.box.diagonal())) : std::nullopt;
    }

    // --- On the bisector ----------------------------------------------------------------------------

    /// How far the patch is from its bisector: by what rounding of its numbers makes of zero, or no more than
    /// its boundary is; or, where halves are no nearer to it, by what its edges state.
    std::optional<double> follow_bisector(const std::string& where, const Patch& patch, const Tile& whole,
                                          const std::optional<double>& boundary) {
        if (spheres_)
            if (const auto near = nearness_by_spheres(*spheres_);
                near && near->distance && near->size <= width_ &&
                (!near->is_bent || *near->distance <= boundary.value_or(0)))
                return near->distance;
        if (boundary)
            if (const auto distance = distance_inside(patch, whole.net, *boundary)) return distance;
        std::vector<Tile> tiles;
        tiles.push_back(whole);
        double most = 0;
        std::size_t count = 0;
        while (!tiles.empty()) {
            Tile tile = std::move(tiles.back());
            tiles.pop_back();
            const Nearness near = nearness(tile, count == 0);
            const bool is_rounding = 2 * near.size > std::exchange(tile.excess, near.size);
            const bool is_told = !near.is_bent || tile.depth >= kBent;
            if (const double to_tip = farthest_from(tips_, tile.net.box()); to_tip <= most_stated(0)) {
                most = std::max(most, to_tip);
                continue;
            }
            if (near.distance &&
                ((near.size <= width_ && is_told) || *near.distance <= boundary.value_or(0) ||
                 (is_rounding && near.size <= stated_))) {
                most = std::max(most, *near.distance);
                continue;
            }
            if (is_outside(patch, tile)) continue;
            if (const auto e = off_bisector(patch, tile)) {
                certificate_.refute(where,
                                    fmt::format("{} is {:.3g} {} than the base", title(own_[0].site),
                                                std::abs(*e), *e < 0 ? "nearer" : "farther"),
                                    0.5 * std::abs(*e));
                return std::nullopt;
            }
            if (++count > tiles_allowed()) {
                certificate_.leave_open(where, fmt::format("its site's excess is below {:.3g}", near.size),
                                        near.distance.value_or(HUGE_VAL));
                return std::nullopt;
            }
            for (Tile& half : tile.halves(tile.longer_axis_of_sides())) tiles.push_back(std::move(half));
        }
        return most;
    }

    /// Bounds of the own sites' excesses all over a tile, and of how far it is from the bisector then.
    struct Nearness {
        double size;
        std::optional<double> distance;
        bool is_bent = false;  // halves may tell the distance better
    };
    /// Halvings after which a tile is taken as it is.
    static constexpr int kBent = 4;
    Nearness nearness(const Tile& tile, bool is_whole) const {
        // Tiles that are many times smaller are few, where gradients all but vanish: forms know of places.
        constexpr int most_depth = 6, least_depth_of_forms = 4;
        if (own_.size() == 1 && own_[0].site.kind == Site::Kind::BoxSide) {
            // Coordinates tell, and grow by one per length.
            const double size = magnitude(space().excess(own_[0], tile.net.box())).upper();
            return {size, size};
        }
        if (tile.depth <= most_depth) {
            const auto part = is_whole ? spheres_ : TouchingSpheres::on(tile.net, own_[0].site, space());
            if (const auto near = part ? nearness_by_spheres(*part) : std::nullopt) return *near;
            // They cost as much as several halves.
            if (is_of_spheres() && tile.depth < least_depth_of_forms) return {HUGE_VAL, std::nullopt};
        }
        const ExcessAlong along(space(), tile.net);
        double size = 0;
        for (const Condition& c : own_) size = std::max(size, magnitude(along.excess(c)).upper());
        return {size, distance(tile.net.box(), size)};
    }
    /// Is the bisector one of a ball and a ball or a plane?
    bool is_of_spheres() const {
        const auto is_tube = [](const Object& o) { return std::holds_alternative<Cylinder>(o); };
        return std::holds_alternative<Sphere>(scene_.base) && own_[0].site.is_object() &&
               !is_tube(scene_.objects[own_[0].site.index]);
    }
    /// None: it takes forms to tell.
    std::optional<Nearness> nearness_by_spheres(const TouchingSpheres& spheres) const {
        double size = 0;
        for (const Condition& c : own_) {
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
                if (!own_[0].site.is_object()) return 1.0;
                const auto growth = spheres.growth(own_[0].site, size, margin);
                return growth ? std::optional(sqrt(Interval(2.0) * *growth).lower()) : std::nullopt;
            },
            size);
    }
    /// Inside the loops, which lift to within `boundary` of their edges. None: it takes tiles to tell.
    std::optional<double> distance_inside(const Patch& patch, const Net& net, double boundary) const {
        const auto* base = std::get_if<Sphere>(&scene_.base);
        if (!base || own_.size() > 1) return std::nullopt;
        double reach = 0;
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop) {
                if (!trim.curve->edge) return std::nullopt;
                for (const auto& piece : edge_pieces_[*trim.curve->edge])
                    for (std::size_t i = 0; i < piece.points.size(); ++i)
                        reach = std::max(reach, (piece.control(i) - base->center).norm());
            }
        const auto inside =
            TouchingSpheres::inside(net, own_[0].site, space(), (reach + boundary) * (1 + 0x1p-40));
        if (!inside || !(inside->excess <= width_)) return std::nullopt;
        return distance_by_spheres(inside->spheres, inside->excess);
    }
    std::size_t tiles_allowed() const { return std::size_t{16} << std::clamp(options_.effort, 0, 40); }

    /// How far from the bisector a point with that excess may be: size / s where the gradient is at least s
    /// on the way there, along which the excess only falls.
    std::optional<double> distance(const Vector<Interval>& box, double size) const {
        return distance_where(
            [&](double margin) -> std::optional<double> {
                const Interval m(-margin, margin);
                const Vector<Interval> around{box[0] + m, box[1] + m, box[2] + m};
                const double slope = sqrt(square(space().gradient(own_[0], around))).lower();
                if (slope > 0 || !own_[0].site.is_object()) return slope;
                const double least = least_slope(space(), own_[0].site.index, around, size);
                return least * most_distance() >= size ? least : 0;
            },
            size);
    }
    /// A bound above that says nothing of short gradients: no edge may be farther away, either.
    double most_distance() const { return 256 * scene_tolerance(); }
    /// How far that is where the gradient's least length within a margin is known.
    template <class Slope>
    static std::optional<double> distance_where(const Slope& slope_within, double size) {
        double margin = kFirstMargin * size;
        for (int tries = 0; tries < 4; ++tries) {
            const std::optional<double> slope = slope_within(margin);
            if (!slope || !(*slope > 0)) return std::nullopt;
            const double reach = (Interval(size) / *slope).upper();
            if (reach <= margin) return reach;
            margin = 1.25 * reach;
        }
        return std::nullopt;
    }

    std::optional<double> off_bisector(const Patch& patch, const Tile& tile) const {
        for (const int i : {0, 1})
            for (const int j : {0, 1})
                for (const Condition& c : own_) {
                    const Interval e = space().excess(c, tile.net.corner(i, j));
                    const Vec2 uv(i == 0 ? tile.lo.x() : tile.hi.x(), j == 0 ? tile.lo.y() : tile.hi.y());
                    const double allowed = 2 * std::max(width_, stated_);
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

    // --- Nothing nearer -----------------------------------------------------------------------------

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

    bool exclude_others(const std::string& where, const Patch& patch, const Tile& whole) {
        auto found = rivals(whole.net);
        if (found.empty()) return true;
        std::vector<Tile> tiles;
        tiles.push_back(whole);
        tiles.back().rivals = std::move(found);
        std::size_t count = 0;
        bool are_held_dropped = false;
        while (!tiles.empty()) {
            if (count > kFew && !std::exchange(are_held_dropped, true))
                for (Tile& t : tiles)
                    std::erase_if(t.rivals, [&](const Rival& r) { return is_held(r.condition.site, own_); });
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
                certificate_.refute(where,
                                    fmt::format("{} is {:.3g} nearer than the base",
                                                title(nearer->first.site), nearer->second),
                                    nearer->second);
                return false;
            }
            if (++count > kMoreTiles * tiles_allowed()) {
                certificate_.leave_open(
                    where, fmt::format("{} may be nearer somewhere", title(tile.rivals[0].condition.site)),
                    HUGE_VAL);
                return false;
            }
            for (Tile& half : tile.halves(tile.longer_axis())) tiles.push_back(std::move(half));
        }
        return true;
    }

    /// Beside edges of nearly parallel bisectors tiles become many, but rivals few.
    static constexpr std::size_t kMoreTiles = 4;

    /// Tiles after which the patch is taken to have places where bisectors touch.
    static constexpr std::size_t kFew = 64;
    /// Tiles after which rivals are told by tangents, too: some are least all along a line.
    static constexpr std::size_t kMany = 1024;

    std::vector<Rival> rivals(const Net& net) const {
        const Vector<Interval>& box = net.box();
        const auto ball = [&](const Condition& c) {
            return c.site.is_object() ? std::get_if<Sphere>(&scene_.objects[c.site.index]) : nullptr;
        };
        const Sphere* own = ball(own_[0]);
        std::optional<LeastPlacesOfSites> least;
        std::vector<Rival> found;
        const Interval clearance = spheres_ ? spheres_->clearance() : space().clearance(box);
        const auto* base = std::get_if<Sphere>(&scene_.base);
        const Vec3 center = middle(box);
        const double reach = (Interval(radius(box)) + Interval(margin_)).upper();
        Room::rivals(center, (clearance + Interval(reach)).upper(), own_, conditions_);
        for (const Condition& c : conditions_) {
            if (is_beside(c, box)) continue;
            const Sphere* rival = ball(c);
            // In the order of what they take.
            if (spheres_ && rival && own && !spheres_->may_be_least(*own, *rival, margin_)) continue;
            if (base && rival && own && LeastPlaces::do_rays_miss(*base, *own, *rival, center, reach))
                continue;
            if (spheres_ && spheres_->is_farther(c.site, margin_)) continue;
            if (!least) least.emplace(scene_, own_[0].site);
            const auto spots = least->of(c.site, 2 * stated_ + tie_width(c.site));
            if (spots && spots->empty()) continue;
            found.push_back({c, spots});
        }
        return found;
    }

    /// Is it a side of the box that a tile lies inside of?
    bool is_beside(const Condition& c, const Vector<Interval>& box) const {
        return c.site.kind == Site::Kind::BoxSide &&
               space().inside_side(c.site.index, box).lower() >= margin_;
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
                e.upper() < -2 * width_ - tie_width(c.site))
                return std::pair(c, -e.upper());
        return std::nullopt;
    }

    /// Need a rival not be looked for in a tile? It is nowhere nearer there, or its excess has no least value
    /// there on the bisector.
    class Test {
    public:
        Test(const Faces& faces, const Net& net, std::size_t count)
            : faces_(faces), scene_(faces.scene_), net_(net), box_(net.box()), count_(count) {
            center_ = middle(box_);
            radius_ = radius(box_) + faces.margin_;  // the bisector itself, too
            base_ = slope_within(scene_.base, center_, radius_, true);
            own_ = slope(faces.own_[0]);
        }

        bool operator()(const Condition& c) const {
            if (c.site.is_object() && faces_.space().is_beyond(c.site.index, center_,
                                                               base_.distance + base_.rounding + 2 * radius_))
                return true;
            const Slope rival = slope(c);
            const double rounding = rival.rounding + (c.site.is_object() ? base_.rounding : 0);
            const double steepest = rival.direction.norm() + rival.turn + kRough;
            if (rival.distance - rounding >= (1 + kRough) * steepest * radius_) return true;
            if (is_nowhere_parallel(c, rival, rival.distance - rounding - (1 + kRough) * steepest * radius_))
                return true;
            const bool alike = faces_.space().are_alike(c, faces_.own_[0]);
            if (alike && are_apart(c)) return true;
            if ((alike && is_farther(c, true)) || (count_ > kFew && is_farther(c, false))) return true;
            return count_ > kMany && least_by_tangents(faces_.space(), c, net_) >= -faces_.tie_width(c.site);
        }

    private:
        /// The excess and its gradient.
        Slope slope(const Condition& c) const {
            if (!c.site.is_object()) {
                const Interval e = faces_.space().excess(c, to_vector<Interval>(center_));
                return {e.mid(), e.radius(), middle(faces_.space().gradient(c, box_)), kRough};
            }
            const Object& object = scene_.objects[c.site.index];
            // The distance from a plane that has the base on one side is signed, so it has no kink in the
            // plane.
            const bool is_sided = faces_.space().is_sided(c.site.index);
            Slope s = slope_within(object, center_, radius_, is_sided);
            if (is_sided && s.direction.dot(middle(faces_.space().object(c.site.index).direction)) < 0) {
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
            const bool is_object = c.site.is_object(), is_own_object = faces_.own_[0].site.is_object();
            const Vec3 &g = rival.direction, &h = own_.direction, &u = base_.direction;
            if (!is_object && !is_own_object) return g.cross(h).norm() > 4 * kRough;
            const auto differ = [](const Vec3& way, double turn) {
                return way.norm() > (1 + kRough) * turn + 4 * kRough;
            };
            if (is_own_object && !faces_.is_apart_ && !differ(h, own_.turn)) return false;
            if (is_object && !differ(g, rival.turn) && !(least > faces_.excess_behind(c.site.index)))
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
            return square(cross(faces_.space().gradient(c, around),
                                faces_.space().gradient_difference(faces_.own_[0], c, around)))
                       .lower() > 0;
        }

        /// Where bisectors touch, the excess changes slowly on the patch. Of objects of one kind the
        /// difference of the excesses does, which is the rival's where the own one is 0, on the bisector.
        bool is_farther(const Condition& c, bool alike) const {
            const Space<Interval>& space = faces_.space();
            const Condition& own = faces_.own_[0];
            const Vector<Interval> gradient =
                alike ? space.gradient_difference(c, own, box_) : space.gradient(c, box_);
            const Changes& known = changes();
            const Interval change =
                magnitude(dot(gradient, known.slopes[0])) + magnitude(dot(gradient, known.slopes[1]));
            Interval excess = space.excess(c, known.corner);
            if (alike) excess = excess - space.excess(own, known.corner);
            return (excess - change).lower() >= -faces_.tie_width(c.site);
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

        const Faces& faces_;
        const Scene& scene_;
        const Net& net_;
        Vector<Interval> box_;
        Vec3 center_;
        double radius_;
        Slope base_, own_;
        std::size_t count_;                       // of tiles so far
        mutable std::optional<Changes> changes_;  // made where they are asked for
    };

    std::span<const EdgeBound> edge_bounds_;
    std::vector<Condition> own_;
    bool is_apart_ = false;                      // the base and the own object are surely two bodies
    std::optional<TouchingSpheres> spheres_;     // about the patch
    mutable std::vector<Condition> conditions_;  // of rivals
    double margin_ = 0;                          // how far the patch is from its bisector
    double width_ = 0;                           // what rounding of the patch's numbers makes of an excess
    double stated_ = 0;                          // the largest error of its edges
    std::vector<Tip> tips_;                      // of the bisector, if the patch has one
};

}  // namespace

void certify_faces(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                   Certificate& certificate) {
    Faces(subject, edges, options, certificate).run();
}

}  // namespace vcell::check
