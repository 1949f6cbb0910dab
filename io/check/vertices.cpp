#include "vertices.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "krawczyk.hpp"

namespace vcell::check {

std::vector<Condition> independent(const Space<Interval>& space, std::span<const Condition> conditions,
                                   const Vec3& p) {
    const Vector<Interval> at = to_vector<Interval>(p);
    // What the gradients chosen so far leave of each, the length of what that is left of, and how well the
    // condition holds the point: as well as its excess is known, which of a side of the box is better than of
    // a tube.
    struct Rest {
        Vec3 g;
        double blur;
        double size = 1;

        double weight() const { return g.norm() / blur; }
    };
    std::vector<Rest> rest;
    const double least = 0x1p-54 * p.cwiseAbs().maxCoeff() + 0x1p-500;
    for (const Condition& c : conditions)
        rest.push_back({middle(space.gradient(c, at)), space.excess(c, at).radius() + least});
    std::vector<Condition> chosen;
    std::vector<Vec3> axes;
    const auto leave = [](Vec3& g, const Vec3& axis) { g -= axis.dot(g) * axis; };
    for (int k = 0; k < 3; ++k) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < rest.size(); ++i)
            if (rest[i].weight() > rest[best].weight()) best = i;
        const double length = rest[best].g.norm();
        // Gradients are known to some 2^-50: what is left of one that is shorter has no direction.
        if (!(length > 0x1p-46 * rest[best].size)) break;
        chosen.push_back(conditions[best]);
        axes.push_back(rest[best].g / length);
        for (std::size_t i = 0; i < rest.size(); ++i) {
            leave(rest[i].g, axes.back());
            // The difference from the one chosen leaves the same, and may be known much better.
            constexpr double alike = 0x1p-20, known = 0x1p-44;
            const Vector<Interval> difference = space.gradient_difference(conditions[i], chosen.back(), at);
            Vec3 g = middle(difference);
            const double size = g.norm();
            if (i == best || !(size < alike * rest[i].size) || !(radius(difference) <= known * size))
                continue;
            for (const Vec3& axis : axes) leave(g, axis);
            rest[i].g = g;
            rest[i].size = size;
        }
    }
    return chosen;
}

namespace {

/// The excess of a site at a point, its gradient, and how much the latter may turn within `reach` of it.
struct Linearized {
    double excess, error;
    Vec3 gradient;
    double turn;
};

/// In doubles with bounds; none: it takes intervals to tell. Pre: the base is no cylinder.
class Linearization {
public:
    Linearization(const Scene& scene, const Space<Interval>& space, const Vec3& p)
        : scene_(scene), space_(space), p_(p), base_(distance(scene.base)) {}

    std::optional<Linearized> of(const Condition& c, double reach) const {
        if (!c.site.is_object()) {
            const Vector<Interval> at = to_vector<Interval>(p_);
            const Interval e = space_.excess(c, at);
            return Linearized{e.mid(), e.radius(), middle(space_.gradient(c, at)), few};
        }
        const Object& object = scene_.objects[c.site.index];
        if (std::holds_alternative<Cylinder>(object) || std::holds_alternative<HollowCylinder>(object) ||
            std::holds_alternative<HollowCone>(object))
            return std::nullopt;
        Distance d = distance(object);
        if (d.length == HUGE_VAL && d.value < 0) d = {-d.value, d.error, -d.direction, d.length};
        if (d.length == HUGE_VAL && !(d.value > reach + d.error)) return std::nullopt;
        const double turn = turn_of(d.length, reach) + turn_of(base_.length, reach) + few;
        if (!(turn < HUGE_VAL)) return std::nullopt;
        const double excess = d.value - base_.value;
        return Linearized{excess, (d.error + base_.error + 0x1p-52 * std::abs(excess)) * (1 + few),
                          d.direction - base_.direction, turn};
    }

private:
    static constexpr double few = 0x1p-50;

    struct Distance {
        double value, error;
        Vec3 direction;
        double length;  // from the center; of a plane infinite
    };
    // A norm of differences is off by less than four roundings, and the distance by one more; a plane's
    // distance by less than eight.
    Distance distance(const Object& object) const {
        if (const auto* ball = std::get_if<Sphere>(&object)) {
            const Vec3 q = p_ - ball->center;
            const double length = q.norm();
            return {length - ball->radius, 0x1.4p-51 * (length + ball->radius), q / length, length};
        }
        if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
            const Vec3 q = p_ - vessel->center;
            const double length = q.norm();
            return {vessel->radius - length, 0x1.4p-51 * (length + vessel->radius), -q / length, length};
        }
        const auto& plane = std::get<Plane>(object);
        const Vec3 n = plane.normal / plane.normal.norm(), q = p_ - plane.point;
        return {n.dot(q), few * n.cwiseAbs().dot(q.cwiseAbs()), n, HUGE_VAL};
    }
    /// Directions from a center turn by so much within a ball (turns.hpp).
    static double turn_of(double length, double reach) {
        if (length == HUGE_VAL) return 0;
        return length > 2 * reach ? 2 * reach / (2 * length - reach) * (1 + few) : HUGE_VAL;
    }

    const Scene& scene_;
    const Space<Interval>& space_;
    Vec3 p_;
    Distance base_;
};

}  // namespace

std::optional<Enclosure<Interval>> enclose_nearby(const Scene& scene, const Space<Interval>& space,
                                                  std::span<const Condition> three, const Vec3& p) {
    if (std::holds_alternative<Cylinder>(scene.base)) return std::nullopt;
    const Linearization around(scene, space, p);
    Eigen::Matrix3d jacobian;
    Vec3 f, error;
    for (int r = 0; r < 3; ++r) {
        const auto row = around.of(three[static_cast<std::size_t>(r)], 0);
        if (!row) return std::nullopt;
        f[r] = row->excess;
        error[r] = row->error;
        jacobian.row(r) = row->gradient;
    }
    const Eigen::Matrix3d inverse = jacobian.inverse();
    if (!inverse.allFinite()) return std::nullopt;
    const Vec3 newton = -(inverse * f);
    const Eigen::Matrix3d size = inverse.cwiseAbs();
    constexpr double above = 1 + 0x1p-40;
    // A box that the step and what rounding makes of it fit in.
    const double half =
        (2 * (newton.cwiseAbs() + size * error).maxCoeff() + 0x1p-80 * p.cwiseAbs().maxCoeff()) * above;
    const double reach = 2 * half;
    Vec3 turn;
    for (int r = 0; r < 3; ++r) {
        const auto row = around.of(three[static_cast<std::size_t>(r)], reach);
        if (!row) return std::nullopt;
        turn[r] = row->turn;
    }
    const Eigen::Matrix3d rest = (Eigen::Matrix3d::Identity() - inverse * jacobian).cwiseAbs() +
                                 0x1p-50 * (Eigen::Matrix3d::Identity() + size * jacobian.cwiseAbs());
    const Vec3 radius =
        (size * (error + reach * turn + 0x1p-50 * f.cwiseAbs()) + half * rest.rowwise().sum()) * above;
    Enclosure<Interval> result;
    for (int r = 0; r < 3; ++r) {
        if (!(std::abs(newton[r]) + radius[r] < half)) return std::nullopt;
        const auto k = static_cast<std::size_t>(r);
        result.center[k] = p[r];
        result.offset[k] = Interval::ball(newton[r], radius[r]);
    }
    return result;
}

namespace {

class Vertices : public Room {
public:
    using Room::Room;

    void run() {
        for (const std::uint32_t i : subject_.vertices) judge(i);
    }

private:
    /// What decides about a vertex: where its true point is, in the coarser or the finer arithmetic.
    template <class T>
    struct Place {
        const Space<T>& space;
        Vector<T> point;
        T distance;  ///< of the stated point
        T clearance = space.clearance(point);

        T excess(const Condition& c) const {
            return c.is_of_object() ? space.object_excess(c.site.index, point, clearance)
                                    : space.excess(c, point);
        }
    };

    void judge(std::size_t i) {
        const CellVertex& v = cell_.vertices[i];
        std::vector<Condition>& conditions = conditions_;
        conditions.clear();
        for (const Site& s : v.sites) add_conditions(s, v, false, conditions);
        if (conditions.size() < 3) {  // on the base both hold
            conditions.clear();
            for (const Site& s : v.sites) add_conditions(s, v, true, conditions);
        }
        if (conditions.empty()) return;  // it has no sites, which is told of them
        const Interval r = space().clearance(to_vector<Interval>(v.point));
        if (const Interval off = magnitude(r - v.radius); off.lower() > v.error + rounding())
            return certificate_.refute(vertex_path(i) + ".radius",
                                       fmt::format("is {}, the base is {} away", v.radius, r.mid()),
                                       off.lower());
        if (conditions.size() == 3)
            if (const auto box = enclose_nearby(scene_, space(), conditions, v.point)) {
                const Place<Interval> place{space(), box->box(), box->distance(v.point)};
                if (decide(i, conditions, place, false)) return;
            }
        std::vector<Condition> triple = independent(space(), conditions, v.point);
        if (triple.size() < 3) return judge_touching(i, conditions);
        const std::array<Condition, 3> three{triple[0], triple[1], triple[2]};
        const auto box = enclose(space(), three, v.point, reach(), 4);
        if (box) {
            const Place<Interval> place{space(), box->box(), box->distance(v.point)};
            if (decide(i, conditions, place, false)) return;
        }
        // Wide arithmetic: many roundings closer, where doubles leave a question open.
        const auto finer = enclose(wide(), three, v.point, reach(), 16);
        if (!finer) return judge_touching(i, conditions);
        const Place<Wide> place{wide(), finer->box(), finer->distance(v.point)};
        decide(i, conditions, place, true);
    }

    /// A Newton step may not leave the vertex farther than that behind.
    double reach() const { return 0x1p-6 * scene_.box.diagonal(); }

    /// What a site asks of a vertex. A side of the box is met by the boundary, or over a base plane by the
    /// region below it: what holds there, or the one that is less wrong if neither does. Where both may hold
    /// as far as the vertex is told, above the base it is the side if the ways off the base lead out of the
    /// box through it, else the rim.
    void add_conditions(const Site& s, const CellVertex& v, bool both,
                        std::vector<Condition>& conditions) const {
        if (s.kind != Site::Kind::BoxSide || !geometry_.is_plane() || is_parallel(s)) {
            conditions.push_back(space().condition_at(s, v.point));
            if (both && is_on_rim_of(s, v)) conditions.push_back({Site::base()});
            return;
        }
        const Condition rim{s, true}, side{s, false};
        if (is_upright(s)) {  // both are the same
            conditions.push_back(rim);
            return;
        }
        // A complete cell goes on to the sides: over the rim it ends on the base alone.
        if (cell_.is_complete && !both) {
            conditions.push_back(side);
            return;
        }
        const auto off = [&](const Condition& c) {
            return magnitude(space().excess(c, to_vector<Interval>(v.point))).lower();
        };
        const double limit = std::max(std::min(off(rim), off(side)), 2 * v.error);
        if (!both && off(rim) <= limit && off(side) <= limit) {
            conditions.push_back(leads_out(s) ? side : rim);
            return;
        }
        for (const Condition& c : {rim, side})
            if (off(c) <= limit) conditions.push_back(c);
    }
    /// Over a base plane: is the vertex where a vessel's wall meets the base, as far as it is told?
    bool is_on_rim_of(const Site& s, const CellVertex& v) const {
        return geometry_.is_plane() && s.is_object() && is_vessel(scene_.objects[s.index]) &&
               magnitude(space().clearance(to_vector<Interval>(v.point))).lower() <= 2 * v.error + rounding();
    }
    /// Do the ways off the base lead out of the box through this side?
    bool leads_out(const Site& side) const {
        const double along = std::get<Plane>(scene_.base).normal[side.index / 2];
        return side.index % 2 == 0 ? along < 0 : along > 0;
    }
    bool is_upright(const Site& side) const {
        return std::get<Plane>(scene_.base).normal[side.index / 2] == 0;
    }
    /// Adds the verdict about vertex i, or returns false where only a finer enclosure can tell. `last`: there
    /// is none finer.
    template <class T>
    bool decide(std::size_t i, std::span<const Condition> conditions, const Place<T>& place, bool last) {
        const CellVertex& v = cell_.vertices[i];
        const double least = lower_bound(place.distance), most = upper_bound(place.distance);
        const auto path = [i] { return vertex_path(i); };
        if (least > v.error) {
            if (v.is_touching) {
                judge_touching(i, conditions);
                return true;
            }
            certificate_.refute(
                path(), fmt::format("lies {:.3g} from the true point, states {:.3g}", least, v.error), least);
            return true;
        }
        if (most > v.error && !last) return false;
        double tie = 0, nearer = 0;
        for (const Condition& c : conditions) {
            const T e = place.excess(c);
            if (lower_bound(magnitude(e)) > tie_width(c.site)) {
                // Beside the stated point the sites may all be equally far: three of them meet elsewhere.
                certificate_.refute(
                    path(),
                    fmt::format("{} is {:.3g} {} than the base", title(c.site), lower_bound(magnitude(e)),
                                upper_bound(e) < 0 ? "nearer" : "farther"),
                    lower_bound(magnitude(e)));
                return true;
            }
            tie = std::max(tie, upper_bound(magnitude(e)));
        }
        std::string note;
        for (const Condition& c : rivals(v, place)) {
            const T e = place.excess(c);
            if (lower_bound(e) > 0) continue;
            if (lower_bound(e) <= 0 && upper_bound(e) >= 0) {
                if (is_held(c.site, conditions)) continue;
                if (!last) return false;
                const double width = upper_bound(magnitude(e));
                const std::string rival = fmt::format("{}, which ties to {:.3g}", title(c.site), width);
                if (cell_.report.moved <= 0) {
                    certificate_.refute(path() + ".sites", "lack " + rival);
                    return true;
                }
                const std::string moved =
                    fmt::format("{}; the scene moved by up to {:.3g}", rival, cell_.report.moved);
                if (width > tie_width(c.site) + 2 * v.error) {
                    certificate_.leave_open(path() + ".sites", "lack " + moved, width);
                    return true;
                }
                // What is nearer by as little is no fault either: in the scene as it was decided about the
                // site may be farther. That no edge of it ends here the tiling says.
                nearer = std::max(nearer, width);
                note = "not among the sites is " + moved + "; ";
                continue;
            }
            if (-upper_bound(e) > tie_width(c.site) + 2 * v.error) {
                certificate_.refute(
                    path(), fmt::format("{} is {:.3g} nearer than the base", title(c.site), -upper_bound(e)),
                    -upper_bound(e));
                return true;
            }
            nearer = std::max(nearer, -lower_bound(e));
            note = fmt::format("{} is nearer, by less than {:.3g}; ", title(c.site), -lower_bound(e));
        }
        if (v.error > most_stated(most) && v.error > most_stated(most, rounded(v.point, conditions))) {
            certificate_.refute(path() + ".error",
                                fmt::format("is {:.3g}, the point is within {:.3g}", v.error, most), v.error);
            return true;
        }
        if (conditions.size() > 3)
            note += fmt::format("a tie of {} sites, verified to {:.3g}", v.sites.size(), tie);
        prove(path(), std::max({most, nearer, tie}), note);
        return true;
    }

    /// How far from where they vanish excesses that are no difference may be, to first order.
    double rounded(const Vec3& p, std::span<const Condition> conditions) const {
        const std::vector<Condition> three = independent(space(), conditions, p);
        if (three.size() < 3) return 0;
        Eigen::Matrix3d gradients;
        for (int r = 0; r < 3; ++r)
            gradients.row(r) =
                middle(space().gradient(three[static_cast<std::size_t>(r)], to_vector<Interval>(p)));
        const Eigen::Matrix3d inverse = gradients.inverse();
        double sum = 0;
        for (int r = 0; r < 3; ++r)
            sum += inverse.col(r).norm() * tie_width(three[static_cast<std::size_t>(r)].site);
        return std::isfinite(sum) ? sum : 0;
    }

    /// Sites that the vertex does not list and that are not far.
    template <class T>
    const std::vector<Condition>& rivals(const CellVertex& v, const Place<T>& place) const {
        const double reach = upper_bound(place.clearance) + 2 * upper_bound(place.distance);
        std::vector<Condition>& found = rivals_;
        Room::rivals(v.point, reach + rounding(), {}, found);
        for (std::uint32_t s = 0; geometry_.is_plane() && s < 6; ++s)
            if (const Site side = Site::box_side(s);
                !is_parallel(side) && (!cell_.is_complete || geometry_.is_upright(side)))
                found.push_back({side, true});
        std::erase_if(found,
                      [&](const Condition& c) { return contains(v.sites, c.site) || is_behind(c.site); });
        return found;
    }
    /// Rays lead away from a side of the box behind the base plane, which may be the base's own.
    bool is_behind(const Site& s) const {
        if (!geometry_.is_plane() || s.kind != Site::Kind::BoxSide || !is_parallel(s)) return false;
        const double along = std::get<Plane>(scene_.base).normal[s.index / 2];
        return s.index % 2 == 0 ? along > 0 : along < 0;
    }
    /// A side of the box along the base plane asks nothing of base points.
    bool is_parallel(const Site& side) const {
        const Vec3& n = std::get<Plane>(scene_.base).normal;
        return n[(side.index / 2 + 1) % 3] == 0 && n[(side.index / 2 + 2) % 3] == 0;
    }

    /// Bisectors that touch: no three sites fix the point. It lies on the boundary as far as the excesses
    /// tell; where along it is not proved.
    void judge_touching(std::size_t i, std::span<const Condition> conditions) {
        const CellVertex& v = cell_.vertices[i];
        const Place<Interval> place{space(), to_vector<Interval>(v.point), Interval(0.0)};
        const std::string where = vertex_path(i);
        double width = 0, steepest = 0;
        for (const Condition& c : conditions) {
            const Interval e = magnitude(place.excess(c));
            if (e.lower() > 2 * v.error + tie_width(c.site))
                return certificate_.refute(
                    where, fmt::format("{} and the base differ by {:.3g}", title(c.site), e.lower()),
                    0.5 * e.lower());
            width = std::max(width, e.upper());
            steepest = std::max(steepest, sqrt(square(space().gradient(c, place.point))).lower());
        }
        for (const Condition& c : rivals(v, place)) {
            const Interval e = place.excess(c);
            if (e.upper() < -2 * v.error - tie_width(c.site))
                return certificate_.refute(
                    where, fmt::format("{} is {:.3g} nearer than the base", title(c.site), -e.upper()),
                    -e.upper());
            if (e.lower() <= 0 && e.upper() >= 0 && conditions.size() < 3 && !is_held(c.site, conditions))
                return certificate_.refute(
                    where + ".sites",
                    fmt::format("lack {}, which ties to {:.3g}", title(c.site), magnitude(e).upper()));
            width = std::max(width, -e.lower());
        }
        if (v.error > most_stated(width))
            return certificate_.refute(
                where + ".error", fmt::format("is {:.3g}, all excesses are within {:.3g}", v.error, width),
                v.error);
        prove(where, steepest > 0 ? width / steepest : width,
              fmt::format("bisectors touch: {} sites tie, verified to {:.3g}", v.sites.size(), width));
    }

    /// Made where it is asked for: few cells need it.
    const Space<Wide>& wide() {
        if (!wide_) wide_.emplace(scene_, subject_.part);
        return *wide_;
    }

    std::optional<Space<Wide>> wide_;
    std::vector<Condition> conditions_;  // of the vertex under judgement
    mutable std::vector<Condition> rivals_;
};

}  // namespace

void certify_vertices(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Vertices(subject, options, certificate).run();
}

}  // namespace vcell::check
