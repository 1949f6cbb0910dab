#include "joined_arcs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/errors.hpp"
#include "distance_gradient.hpp"

namespace vcell::whole {

namespace {

constexpr double u = std::numeric_limits<double>::epsilon();

// The direction in which distance from an object grows, and a bound on how much that turns within a ball.
struct Gradient {
    Vec3 direction;
    double turn;
};

// Pre: the object is solid or a plane, and the point is outside of it; or a vessel, and the point inside.
Gradient gradient(const Object& object, const Vec3& p, double radius) {
    const auto [direction, arm] = distance_gradient(object, p);
    if (std::holds_alternative<Plane>(object))
        return {direction, distance_from(object, p) > 2 * radius ? 4 * u : infinity};
    const double off = radius + 16 * u * (p.cwiseAbs().sum() + place_of(object).cwiseAbs().sum());
    return {direction, arm > off ? off / (arm - off) : infinity};
}

class ArcJoiner {
public:
    ArcJoiner(const DecidedDiagram& decided, std::uint32_t object, const Cell& cell,
              std::span<const CutArc> arcs)
        : decided_(decided), object_(object), cell_(cell), arcs_(arcs), loose_of_(arcs.size()) {
        for (std::uint32_t a = 0; a < arcs.size(); ++a)
            for (const std::size_t e : {0, 1})
                if (!arcs[a].edge->vertices.empty() && !arcs[a].vertices[e]) {
                    loose_of_[a][e] = static_cast<std::uint32_t>(loose_.size());
                    loose_.push_back({a, e, &cell.vertices[arcs[a].edge->vertices[e]]});
                }
        find_moves();
    }

    std::vector<JoinedArcs> operator()() {
        for (std::uint32_t i = 0; i < loose_.size(); ++i) continuations_.push_back(nearest(i));
        for (std::uint32_t i = 0; i < loose_.size(); ++i) prove(i);
        std::vector<JoinedArcs> joined;
        std::vector<bool> is_done(arcs_.size(), false);
        for (std::uint32_t a = 0; a < arcs_.size(); ++a)
            if (!is_done[a]) joined.push_back(follow(a, is_done));
        return joined;
    }

private:
    struct LooseEnd {
        std::uint32_t arc;
        std::size_t end;
        const CellVertex* vertex;
    };
    // The arc goes on with that of another loose end, moved by so many edges of the box.
    struct Continuation {
        std::uint32_t loose;
        Image image;
        Interval length{0.0}, clearance{0.0};  // of what is between
    };

    // Where the cell comes again: there, and next to there, by its object's own periods.
    void find_moves() {
        moves_ = {here};
        for (const Image& period : decided_.periods(object_)) {
            const std::vector<Image> before = moves_;
            for (const Image& m : before)
                for (const int times : {-1, 1}) moves_.push_back(plus(m, period, times));
        }
    }

    [[noreturn]] void fail(std::uint32_t i) const {
        throw UndecidedError("void network: how the edge of objects " + names_of(arcs_[loose_[i].arc].sites) +
                             " goes on where the cell of object " + std::to_string(object_) +
                             " is cut is not told");
    }

    bool has_sites_of(const CutArc& a, const CutArc& b, const Image& image) const {
        return a.sites.size() == b.sites.size() && std::ranges::all_of(b.sites, [&](NetworkSite site) {
                   site.image = representative(plus(site.image, image), decided_.periods(site.site.index));
                   return std::ranges::binary_search(a.sites, site);
               });
    }

    Continuation nearest(std::uint32_t i) const {
        // Where edges run along a cut their ends are far from each other.
        double least = 0x1p-12 * cell_.scene.box.diagonal();
        std::optional<Continuation> found;
        for (std::uint32_t j = 0; j < loose_.size(); ++j)
            for (const Image& image : moves_) {
                if (i == j) continue;
                const double off = (place_at(Continuation{j, image}) - loose_[i].vertex->point).norm();
                if (!(off < least) || !has_sites_of(arcs_[loose_[i].arc], arcs_[loose_[j].arc], image))
                    continue;
                least = off;
                found = Continuation{j, image};
            }
        if (!found) fail(i);
        return *found;
    }

    void prove(std::uint32_t i) {
        Continuation& next = continuations_[i];
        const Continuation& back = continuations_[next.loose];
        if (back.loose != i || plus(back.image, next.image) != here || !is_one(i, next)) fail(i);
        // Chords, and directions along the way, are within 30 degrees of one direction: it is no longer than
        // its chord by this factor.
        constexpr double longer = 1.16;
        const CellVertex &a = *loose_[i].vertex, &b = *loose_[next.loose].vertex;
        const double apart = apart_of(i, next), chord = (a.point - place_at(next)).norm();
        next.length = Interval(std::max(0.0, 2 * chord - apart), Interval::up(longer * apart));
        next.clearance = hull(Interval::ball(a.radius, a.error), Interval::ball(b.radius, b.error)) +
                         Interval(-next.length.upper(), next.length.upper());
    }

    // Where the end is that the arc goes on at.
    Vec3 place_at(const Continuation& next) const {
        return loose_[next.loose].vertex->point + decided_.lattice().shift(next.image);
    }
    // A bound on how far the two true ends are from each other, and from where they are said to be.
    double apart_of(std::uint32_t i, const Continuation& next) const {
        const Vec3 &p = loose_[i].vertex->point, q = place_at(next);
        return (p - q).norm() + loose_[i].vertex->error + loose_[next.loose].vertex->error +
               16 * u * (p.cwiseAbs().sum() + q.cwiseAbs().sum());
    }

    // What the arc's own object and two others are, and the rest of the scene.
    std::array<const Object*, 2> two_sites(const CutArc& arc) const {
        return {&object_of(arc.edge->sites[0]), &object_of(arc.edge->sites[1])};
    }
    const Object& object_of(const Site& site) const { return cell_.scene.objects[place_of_site(site)]; }
    std::size_t place_of_site(const Site& site) const {
        return cell_.scene.images.empty() ? cell_.scene.place(site.index) : site.index;
    }

    bool is_one(std::uint32_t i, const Continuation& next) const {
        const LooseEnd &a = loose_[i], &b = loose_[next.loose];
        if (a.vertex->is_touching || b.vertex->is_touching) return false;
        const Vec3 &p = a.vertex->point, by = decided_.lattice().shift(next.image), q = place_at(next);
        // An arc is where its curve is, but for that one's error.
        const double apart = apart_of(i, next),
                     blur = apart + std::max(arcs_[a.arc].edge->error, arcs_[b.arc].edge->error);
        const double radius = 32 * blur;  // far more than `blur`, as halved arcs end anywhere
        const std::optional<Vec3> along = direction(arcs_[a.arc], p, radius);
        if (!along) return false;
        const std::optional<bool> first = starts_along(a, Vec3::Zero(), p, *along, blur, radius),
                                  second = starts_along(b, by, q, *along, blur, radius);
        return first && second && *first != *second && is_alone(arcs_[a.arc], p, apart) &&
               is_alone(arcs_[b.arc], b.vertex->point, apart);
    }

    // The direction of the trisector in the ball, if no chord of it is farther from that than 30 degrees.
    std::optional<Vec3> direction(const CutArc& arc, const Vec3& p, double radius) const {
        const std::array<const Object*, 2> others = two_sites(arc);
        const Gradient own = gradient(cell_.scene.base, p, radius), first = gradient(*others[0], p, radius),
                       second = gradient(*others[1], p, radius);
        const Vec3 g = first.direction - own.direction, h = second.direction - own.direction,
                   along = g.cross(h);
        const double turn = std::hypot(own.turn + first.turn, own.turn + second.turn),
                     slope = std::hypot(g.norm(), h.norm()) * turn / along.norm();
        if (!(slope <= 0.5)) return std::nullopt;
        return along.normalized();
    }

    // Does the arc start from its end p where the direction ascends? None if what is in the ball is no longer
    // than errors may be.
    std::optional<bool> starts_along(const LooseEnd& end, const Vec3& by, const Vec3& p, const Vec3& along,
                                     double blur, double radius) const {
        const RationalCurve3& curve = arcs_[end.arc].edge->curve;
        const double begin = curve.domain_begin(), length = curve.domain_end() - begin;
        constexpr int halvings = 50;
        for (int n = 1; n < halvings; ++n) {
            const double part = std::ldexp(length, -n);
            const RationalCurve3 piece = end.end == 0
                                             ? restricted(curve, begin, begin + part)
                                             : restricted(curve, begin + length - part, begin + length);
            if (!std::ranges::all_of(piece.points, [&](const Eigen::Vector4d& c) {
                    return (c.head<3>() + by - p).norm() < radius - blur;
                }))
                continue;
            const Eigen::Vector4d& far = end.end == 0 ? piece.points.back() : piece.points.front();
            const double height = along.dot(far.head<3>() + by - p);
            return std::abs(height) > 2 * blur ? std::optional(height > 0) : std::nullopt;
        }
        return std::nullopt;
    }

    // Is nothing else as near as the arc's objects, all the way?
    bool is_alone(const CutArc& arc, const Vec3& p, double apart) const {
        const double way = 3 * apart;
        std::vector<std::size_t> own;
        for (const Site& s : arc.edge->sites) own.push_back(place_of_site(s));
        for (const Site& s : arc.edge->extra_sites) own.push_back(place_of_site(s));
        const double clearance = distance_from(cell_.scene.base, p);
        for (std::size_t x = 0; x < cell_.scene.objects.size(); ++x) {
            if (std::ranges::find(own, x) != own.end()) continue;
            const Object& object = cell_.scene.objects[x];
            const double rounding = 0x1p-46 * (p.cwiseAbs().sum() + place_of(object).cwiseAbs().sum() +
                                               place_of(cell_.scene.base).cwiseAbs().sum() + clearance);
            if (!(distance_from(object, p) - clearance > 2 * way + rounding)) return false;
        }
        const Box& box = decided_.scene().box;
        for (int k = 0; k < 3; ++k)
            if (!decided_.lattice().repeats(k) && !(std::min(p[k] - box.min[k], box.max[k] - p[k]) > way))
                return false;
        return true;
    }

    // ---- Following

    JoinedArcs follow(std::uint32_t first, std::vector<bool>& is_done) const {
        // Backwards to a vertex, or all around; then forwards.
        Step start{first, 0, here};
        while (const std::optional<Step> before = beyond(start)) {
            start = *before;
            if (start.arc == first) break;
        }
        if (arcs_[start.arc].edge->vertices.empty()) {
            is_done[first] = true;
            return {{first}, {here}, std::nullopt, here, Interval(0.0), std::nullopt};
        }
        JoinedArcs result;
        // The first arc is seen where it is in the cell.
        Step at{start.arc, 1 - start.end, here};
        const std::uint32_t begin = start.arc;
        result.arcs = {begin};
        result.images = {here};
        is_done[begin] = true;
        while (const std::optional<Step> next = beyond(at)) {
            add_between(*loose_of_[at.arc][at.end], result);
            at = *next;
            if (at.arc == begin) {
                result.image = at.image;
                return result;
            }
            result.arcs.push_back(at.arc);
            result.images.push_back(at.image);
            is_done[at.arc] = true;
        }
        result.vertices = {*arcs_[begin].vertices[start.end], *arcs_[at.arc].vertices[at.end]};
        result.image = at.image;
        return result;
    }

    void add_between(std::uint32_t loose, JoinedArcs& joined) const {
        const Continuation& next = continuations_[loose];
        joined.length_between += next.length;
        joined.clearance_between =
            joined.clearance_between ? hull(*joined.clearance_between, next.clearance) : next.clearance;
    }

    // An end of an arc, where that has been moved to.
    struct Step {
        std::uint32_t arc;
        std::size_t end;
        Image image;
    };
    // The far end of the arc that goes on at this one; none in a vertex.
    std::optional<Step> beyond(const Step& at) const {
        const std::optional<std::uint32_t> loose = loose_of_[at.arc][at.end];
        if (!loose) return std::nullopt;
        const Continuation& next = continuations_[*loose];
        return Step{loose_[next.loose].arc, 1 - loose_[next.loose].end, plus(at.image, next.image)};
    }

    const DecidedDiagram& decided_;
    const std::uint32_t object_;
    const Cell& cell_;
    const std::span<const CutArc> arcs_;
    std::vector<std::array<std::optional<std::uint32_t>, 2>> loose_of_;
    std::vector<LooseEnd> loose_;
    std::vector<Image> moves_;
    std::vector<Continuation> continuations_;  // of each loose end
};

}  // namespace

bool is_cut(const DecidedDiagram& decided, const Site& site) {
    return site.kind == Site::Kind::End ||
           (site.kind == Site::Kind::BoxSide && decided.lattice().repeats(static_cast<int>(site.index / 2)));
}

std::vector<JoinedArcs> join_arcs(const DecidedDiagram& decided, std::uint32_t object, const Cell& cell,
                                  std::span<const CutArc> arcs) {
    return ArcJoiner(decided, object, cell, arcs)();
}

}  // namespace vcell::whole
