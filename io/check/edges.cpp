#include "edges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "../pictures/trims.hpp"
#include "excess.hpp"
#include "middle_planes.hpp"
#include "tangents.hpp"
#include "touching_spheres.hpp"

namespace vcell::check {
namespace {

struct EdgePart {
    Net net;
    int depth = 0;
    std::optional<TouchingSpheres> spheres;
};

class Edges : public Room {
public:
    Edges(const Subject& subject, const CheckOptions& options, Certificate& certificate,
          std::vector<EdgeBound>& bounds)
        : Room(subject, options, certificate), bounds_(bounds) {}

    void run() {
        for (const std::uint32_t i : subject_.edges) judge(i);
    }

private:
    void judge(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        std::string where = edge_path(i);
        if (e.sites[0] == e.sites[1] && !rim_[i])
            return certificate_.refute(where + ".sites", fmt::format("are {} twice", title(e.sites[0])));
        if (!check_ends(i)) return;
        conditions_.clear();
        for (const Site& s : label(i)) conditions_.push_back({s, geometry_.is_plane() && rim_[i] == s});
        // A side of the box may lean out of its own rim: it meets the boundary there.
        if (e.sites[0] == e.sites[1]) conditions_.push_back({e.sites[0]});
        const auto is_first = [&](const Condition& c) { return contains(e.sites, c.site); };
        std::ranges::stable_partition(conditions_, is_first);
        middle_planes_.reset();
        if (conditions_[0].site.is_object() && conditions_[1].site.is_object())
            middle_planes_ = middle_planes(scene_.objects[conditions_[0].site.index],
                                           scene_.objects[conditions_[1].site.index]);

        const Vec3 origin = e.curve.points.front().head<3>();
        std::vector<EdgePart>& parts = parts_;
        parts.clear();
        if (const auto span = only_span<3>(e.curve, origin))
            parts.push_back(part(Net(*span, origin), 0));
        else
            for (const auto& each : spans<3>(e.curve, origin)) parts.push_back(part(Net(each, origin), 0));
        error_ = full_error(i);
        EdgeBound bound{0, 0, HUGE_VAL};
        if (!follow_arc(i, where, parts, bound)) return;
        nearer_ = 0;
        excess_ = bound.excess;
        distance_ = bound.distance;
        if (!exclude_others(where, parts)) return;
        if (e.error > most_stated(bound.distance) && e.error > most_stated(trims_off(i)))
            return certificate_.refute(
                where + ".error",
                fmt::format("is {:.3g}, the curve is within {:.3g} of the true one", e.error, bound.distance),
                e.error);
        bounds_[i] = bound;
        prove(std::move(where), std::max(bound.distance, nearer_));
    }

    bool check_ends(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        const auto &first = edge_pieces_[i].front(), &last = edge_pieces_[i].back();
        const std::array ends{first.control(0), last.control(last.points.size() - 1)};
        if (e.vertices.empty()) {
            const double gap = (ends[0] - ends[1]).norm();
            if (gap <= 2 * e.error + rounding()) return true;
            certificate_.refute(edge_path(i) + ".curve",
                                fmt::format("is closed, but its ends are {:.3g} apart", gap), gap);
            return false;
        }
        for (int k = 0; k < 2; ++k) {
            const CellVertex& v = cell_.vertices[e.vertices[k]];
            const double gap = (ends[k] - v.point).norm();
            if (gap <= e.error + v.error + rounding()) continue;
            certificate_.refute(edge_path(i) + ".vertices",
                                fmt::format("the curve {} {:.3g} away from vertex {}", k ? "ends" : "starts",
                                            gap, e.vertices[k]),
                                gap);
            return false;
        }
        return true;
    }

    /// How far trims are seen to be off their edge: its error is said to be theirs, too.
    double trims_off(std::size_t i) const {
        constexpr int places = 16;
        double most = 0;
        for (const Patch& patch : patches_)
            for (const auto& loop : patch.loops)
                for (const Trim& trim : loop) {
                    if (trim.curve->edge != i) continue;
                    for (int k = 0; k <= places; ++k) {
                        const double t = trim.begin() + (trim.end() - trim.begin()) * k / places;
                        const Vec3 on_edge =
                            evaluate(edge_pieces_[i], edge_parameter(*trim.curve, cell_.edges[i].curve, t));
                        most = std::max(most, (lift(patch, evaluate(trim.pieces, t)).p - on_edge).norm());
                    }
                }
        return most;
    }

    // --- On the arc ---------------------------------------------------------------------------------

    struct Reach {
        double distance, slope;  ///< the least singular value that far around
        double growth;           ///< the lesser of both excesses', as growth() has it
    };
    /// What bounds on the excesses e and f say about the distance from the arc, or nothing where gradients
    /// are parallel in the box.
    ///
    /// Both excesses fall in proportion to each other, to zero, along the path that takes the shortest way:
    /// with their gradients g and h it is |e h - f g| / |g x h| long for some place in the box. Where f - e
    /// is known as closely as h - g it is as long as |e (h - g) - (f - e) g| / |g x (h - g)|.
    std::optional<Reach> distance(const Vector<Interval>& box, const std::array<Interval, 2>& excesses,
                                  double size, const std::optional<Interval>& apart = std::nullopt) const {
        return reach(
            [&](double margin) -> std::optional<Reach> {
                const Interval m(-margin, margin);
                const Vector<Interval> x{box[0] + m, box[1] + m, box[2] + m};
                const Vector<Interval> g = space().gradient(conditions_[0], x),
                                       h = space().gradient(conditions_[1], x);
                const Vector<Interval> difference =
                    space().gradient_difference(conditions_[1], conditions_[0], x);
                // Either gradient may be far shorter than the other, or nearly the same.
                const Interval by_both = square(cross(g, h)), by_one = square(cross(g, difference));
                const Interval sine(std::max(by_both.lower(), by_one.lower()),
                                    std::min(by_both.upper(), by_one.upper()));
                const Interval sum = square(g) + square(h);
                if (!(sine.lower() > 0)) return std::nullopt;
                // Of a matrix with rows g and h: |g x h|^2 is the product of the squared singular values, of
                // which the greater is below the sum of squares.
                const double slope = sqrt(sine / sum).lower();
                const auto& [e, f] = excesses;
                const Vector<Interval> across = apart ? e * difference - *apart * g : e * h - f * g;
                const Interval way = sqrt(square(across) / sine);
                return Reach{std::min((Interval(size) / slope).upper(), way.upper()), slope,
                             std::min(growth_of(conditions_[0], g), growth_of(conditions_[1], h))};
            },
            size);
    }
    /// The first one that lies within the margin for which it was found.
    template <class Find>
    static std::optional<Reach> reach(const Find& find, double size) {
        double margin = kFirstMargin * size;
        for (int tries = 0; tries < 4; ++tries) {
            const std::optional<Reach> found = find(margin);
            if (!found || found->distance <= margin) return found;
            margin = 1.25 * found->distance;
        }
        return std::nullopt;
    }

    EdgePart part(Net net, int depth) const {
        EdgePart result{std::move(net), depth, {}};
        result.spheres = TouchingSpheres::along(result.net, space());
        if (result.spheres)
            for (std::size_t k = 0; k < 2; ++k)
                if (result.spheres->refer_to(conditions_[k].site)) break;
        return result;
    }

    /// All along a part: how large both excesses are together, and those of other sites of the edge.
    struct Distances {
        std::array<Interval, 2> excesses;
        double size, others;
        std::optional<Reach> found;
    };
    template <class Excess>
    std::optional<Distances> distances(const Excess& excess) const {
        std::array<Interval, 2> own;
        Interval others(0.0);
        for (std::size_t k = 0; k < conditions_.size(); ++k) {
            const std::optional<Interval> e = excess(conditions_[k]);
            if (!e) return std::nullopt;
            if (k < 2)
                own[k] = *e;
            else
                others = hull(others, magnitude(*e));
        }
        return Distances{own, sqrt(square(own[0]) + square(own[1])).upper(), others.upper(), {}};
    }
    Distances by_forms(const EdgePart& part) const {
        const ExcessAlong along(space(), part.net);
        Distances result = *distances([&](const Condition& c) { return std::optional(along.excess(c)); });
        result.found = distance(part.net.box(), result.excesses, result.size);
        if (result.found && result.found->distance <= error_) return result;
        if (const auto apart = along.excess_difference(conditions_[1], conditions_[0]))
            result.found = distance(part.net.box(), result.excesses, result.size, apart);
        if (!middle_planes_ || !(part.net.sizes().least_weight > 0)) return result;
        for (const MiddlePlane& plane : *middle_planes_) {
            const auto found = distance_in(plane, part.net, result.excesses[0]);
            if (found && !(result.found && result.found->distance <= found->distance)) result.found = found;
        }
        return result;
    }
    /// As distance(), by the plane and the first site's excess: where both are 0 the second one's is, too.
    std::optional<Reach> distance_in(const MiddlePlane& plane, const Net& net, const Interval& excess) const {
        const Interval off = plane.over(net);
        const double size = sqrt(square(excess) + square(off)).upper();
        return reach(
            [&](double margin) -> std::optional<Reach> {
                const Interval m(-margin, margin);
                const Vector<Interval> x{net.box()[0] + m, net.box()[1] + m, net.box()[2] + m};
                const Vector<Interval> g = space().gradient(conditions_[0], x),
                                       h = space().gradient(conditions_[1], x), &n = plane.normal;
                const Interval sine = square(cross(g, n));
                if (!(sine.lower() > 0)) return std::nullopt;
                const double slope = sqrt(sine / (square(g) + square(n))).lower();
                const Interval way = sqrt(square(excess * n - off * g) / sine);
                return Reach{std::min((Interval(size) / slope).upper(), way.upper()), slope,
                             std::min(growth_of(conditions_[0], g), growth_of(conditions_[1], h))};
            },
            size);
    }
    /// Are both sides of the box that meet at a right angle?
    static bool is_box_edge(const Condition& a, const Condition& b) {
        const auto is_side = [](const Condition& c) {
            return c.site.kind == Site::Kind::BoxSide && !c.at_rim;
        };
        return is_side(a) && is_side(b) && a.site.index / 2 != b.site.index / 2;
    }
    /// None: it takes forms to tell.
    std::optional<Distances> by_spheres(const EdgePart& part) const {
        if (!part.spheres) return std::nullopt;
        std::optional<Distances> result =
            distances([&](const Condition& c) { return part.spheres->excess(c); });
        if (!result) return std::nullopt;
        if (is_box_edge(conditions_[0], conditions_[1]))
            result->found = Reach{result->size, 1, growth_of(conditions_[0], {})};
        else if (!conditions_[0].at_rim && !conditions_[1].at_rim)
            result->found = reach(
                [&](double margin) -> std::optional<Reach> {
                    const auto found =
                        part.spheres->slopes(conditions_[0].site, conditions_[1].site, result->size, margin);
                    return found ? std::optional(Reach{(Interval(result->size) / found->both).upper(),
                                                       found->both, found->growth})
                                 : std::nullopt;
                },
                result->size);
        else
            result->found = distance(part.net.box(), result->excesses, result->size);
        return result;
    }

    /// How far a part is from the arc at most, where gradients do not tell: no farther than from an end, in
    /// which the arc ends, too. A short one on both bisectors is where it is stated to be as far as the scene
    /// tolerates: finer than that no node is told from what all but is one.
    double distance_by_node(std::size_t i, const Vector<Interval>& box, bool is_on_both) const {
        double least = HUGE_VAL;
        for (const std::uint32_t v : cell_.edges[i].vertices) {
            const CellVertex& end = cell_.vertices[v];
            const Vector<Interval> way = box - to_vector<Interval>(end.point);
            least = std::min(least, (sqrt(square(way)) + Interval(end.error)).upper());
        }
        const bool is_short = radius(box) <= error_ && error_ <= most_stated(0);
        return is_on_both && is_short ? std::min(least, error_) : least;
    }

    bool follow_arc(std::size_t i, const std::string& where, const std::vector<EdgePart>& whole,
                    EdgeBound& bound) {
        const double width = std::max(tie_width(conditions_[0].site), tie_width(conditions_[1].site));
        std::size_t count = 0;
        std::vector<EdgePart> parts;  // halves
        for (std::size_t next = 0; next < whole.size() || !parts.empty();) {
            std::optional<EdgePart> last;
            if (!parts.empty()) {
                last.emplace(std::move(parts.back()));
                parts.pop_back();
            }
            const EdgePart& part = last ? *last : whole[next++];
            std::optional<Distances> known = by_spheres(part);
            if (!known || !known->found || !(known->found->distance <= error_ + width / known->found->slope))
                known = by_forms(part);
            const auto& [excesses, size, others, found] = *known;
            const double allowed = found ? error_ + width / found->slope : 0;
            const double growth = found ? found->growth
                                        : std::min(this->growth(conditions_[0], part.net.box()),
                                                   this->growth(conditions_[1], part.net.box()));
            const bool follows = found && found->distance <= allowed;
            // Where the bisectors touch no place on either is much nearer to the arc than the others.
            const bool touches = !found && part.depth >= kTouching && size <= width && growth > 0;
            // Next to a node, in which more than two arcs meet or nearly do, gradients are parallel, too.
            const double from_node =
                follows || touches ? HUGE_VAL : distance_by_node(i, part.net.box(), size <= width);
            const bool is_by_node = from_node <= error_ && growth > 0;
            if ((follows || touches || is_by_node) && others <= 2 * (is_by_node ? error_ : allowed) + width) {
                bound.distance = std::max(bound.distance, follows   ? found->distance
                                                          : touches ? size / growth
                                                                    : from_node);
                bound.excess = std::max(bound.excess, size);
                bound.growth = std::min(bound.growth, growth);
                continue;
            }
            if (off_bisector(where, part.net, width)) return false;
            if (++count > parts_allowed(whole.size())) {
                certificate_.leave_open(
                    where + ".curve",
                    found ? fmt::format("its sites' excesses are below {:.3g}, its error is {:.3g}", size,
                                        error_)
                          : "its sites' bisectors are too nearly parallel",
                    found ? found->distance : HUGE_VAL);
                return false;
            }
            for (Net& half : part.net.halves(0)) parts.push_back(this->part(std::move(half), part.depth + 1));
        }
        return true;
    }

    /// Parts after which a rival's gradients are not asked alone.
    static constexpr std::size_t kFewParts = 16;
    /// Parts after which a rival is told by tangents, too.
    static constexpr std::size_t kManyParts = 256;

    /// Halvings after which gradients that are still parallel somewhere are taken to be so at a point.
    static constexpr int kTouching = 12;

    /// An edge of many spans gets more, so that each may be divided.
    std::size_t parts_allowed(std::size_t spans) const {
        constexpr std::size_t few = 16;
        return (std::size_t{1} << std::clamp(options_.effort, 0, 40)) * std::max(spans, few) / few;
    }

    /// Refutes a curve whose end is off one of its bisectors by more than its error.
    bool off_bisector(const std::string& where, const Net& net, double width) {
        for (const int end : {0, 1}) {
            const Vector<Interval> p = net.corner(end, 0);
            for (const Condition& c : conditions_) {
                const Interval e = magnitude(space().excess(c, p));
                const Interval about(-error_, error_);
                const Vector<Interval> near{p[0] + about, p[1] + about, p[2] + about};
                const double slope = std::min(2.0, sqrt(square(space().gradient(c, near))).upper());
                if (!(e.lower() > (Interval(slope) * error_ + 2 * width).upper())) continue;
                const bool is_nearer = space().excess(c, p).upper() < 0;
                certificate_.refute(where + ".curve",
                                    fmt::format("{} is {:.3g} {} than the base", title(c.site), e.lower(),
                                                is_nearer ? "nearer" : "farther"),
                                    e.lower() / slope);
                return true;
            }
        }
        return false;
    }

    // --- Nothing nearer -----------------------------------------------------------------------------

    bool exclude_others(const std::string& where, const std::vector<EdgePart>& whole) {
        struct Task {
            EdgePart part;
            std::vector<Condition> rivals;
        };
        std::vector<Task> tasks;
        for (const EdgePart& p : whole) {
            find_rivals(p);
            drop_farther(p, rivals_);
            if (!rivals_.empty()) tasks.push_back({p, rivals_});
        }
        std::size_t count = 0;
        while (!tasks.empty()) {
            Task task = std::move(tasks.back());
            tasks.pop_back();
            if (task.part.depth > 0) drop_farther(task.part, task.rivals);
            if (task.rivals.empty()) continue;
            // What gradients over a whole part make of a little at one end of it may be far too much.
            const double most = task.part.depth < kTouching ? most_stated(distance_) : HUGE_VAL;
            std::erase_if(task.rivals, Farther{*this, task.part.net, most});
            // A rival that all but ties along the whole edge: polynomials tell that in one part.
            if (count >= kFewParts) {
                const ExcessAlong along(space(), task.part.net);
                std::erase_if(task.rivals, [&](const Condition& c) {
                    double least = along.excess(c).lower();
                    if (least < 0 && count >= kManyParts)
                        least = std::max(least, least_by_tangents(space(), c, task.part.net));
                    if (least >= 0) return true;
                    if (is_farther_than_twin(c, along, task.part.net.box(), whole)) return true;
                    if (!ties_at_ends(c, whole) &&
                        is_little(c, least, this->growth(c, task.part.net.box()), most))
                        return true;
                    return is_held(c.site, conditions_);
                });
            }
            if (task.rivals.empty()) continue;
            for (const int end : {0, 1})
                for (const Condition& c : task.rivals) {
                    const Interval e = space().excess(c, task.part.net.corner(end, 0));
                    if (!(e.upper() < -allowance(c))) continue;
                    certificate_.refute(
                        where + ".curve",
                        fmt::format("{} is {:.3g} nearer than the base", title(c.site), -e.upper()),
                        -e.upper());
                    return false;
                }
            if (++count > parts_allowed(whole.size())) {
                certificate_.leave_open(where + ".curve",
                                        fmt::format("{} may be nearer somewhere", title(task.rivals[0].site)),
                                        HUGE_VAL);
                return false;
            }
            for (Net& half : task.part.net.halves(0))
                tasks.push_back({part(std::move(half), task.part.depth + 1), task.rivals});
        }
        return true;
    }

    /// Is a rival that all but coincides with one of the edge's sites no nearer than that one, but for what
    /// the edge's error makes of what they differ by, and farther somewhere on the edge?
    bool is_farther_than_twin(const Condition& c, const ExcessAlong& along, const Vector<Interval>& box,
                              const std::vector<EdgePart>& whole) const {
        return std::ranges::any_of(std::span(conditions_).first(2), [&](const Condition& own) {
            const auto farther = along.excess_difference(c, own);
            if (!farther) return false;
            const auto little = [&](const Vector<Interval>& about) {
                return (sqrt(square(space().gradient_difference(c, own, about))) * Interval(2 * error_))
                    .upper();
            };
            const double growth = this->growth(c, box);
            if (!(farther->lower() >= -little(box)) || !(growth > 0)) return false;
            nearer_ = std::max(nearer_, -farther->lower() / growth);
            return std::ranges::any_of(whole, [&](const EdgePart& p) {
                // Next to the middle of a span, where boxes are small.
                constexpr int halvings = 6;
                Net near = p.net.halves(0)[1];
                for (int i = 0; i < halvings; ++i) near = near.halves(0)[0];
                const auto there = ExcessAlong(space(), near).excess_difference(c, own);
                return there && there->lower() > little(near.box());
            });
        });
    }

    /// Is a site as near as the base at the ends of all spans? Then the edge may be one of more sites.
    bool ties_at_ends(const Condition& c, const std::vector<EdgePart>& whole) const {
        return std::ranges::all_of(whole, [&](const EdgePart& p) {
            return std::ranges::all_of(std::array{0, 1}, [&](int end) {
                return !(space().excess(c, p.net.corner(end, 0)).lower() > allowance(c));
            });
        });
    }

    /// Sites beside the edge's own that may be nearer than the base somewhere on the curve.
    void find_rivals(const EdgePart& part) {
        const Vector<Interval>& box = part.net.box();
        const Interval clearance = part.spheres ? part.spheres->clearance() : space().clearance(box);
        Room::rivals(middle(box), (clearance + Interval(radius(box))).upper(), conditions_, rivals_);
    }

    /// Drops rivals that are farther all along a span.
    void drop_farther(const EdgePart& part, std::vector<Condition>& rivals) const {
        const Vector<Interval>& box = part.net.box();
        // Hardly more than the curve itself may be off: else a finer look is worth while.
        constexpr double hardly = 16;
        const double most = hardly * distance_;
        std::erase_if(rivals, [&](const Condition& c) {
            if (c.site.kind == Site::Kind::BoxSide) {
                const double least = space().inside_side(c.site.index, box).lower();
                return least >= 0 || is_little(c, least, growth_of(c, {}), most);
            }
            if (!part.spheres || !c.site.is_object()) return false;
            const auto least = part.spheres->least(c.site);
            if (!least) return false;
            if (*least >= 0) return true;
            const auto excess = part.spheres->excess(c);
            if (!excess) return false;
            const auto growth = part.spheres->growth(c.site, std::max(0.0, -excess->lower()), most);
            return is_little(c, excess->lower(), growth ? *growth : this->growth(c, box), most);
        });
    }
    /// Is an excess that is no less than `least`, which is negative, within the allowance, and is what that
    /// means for the boundary, where it grows by `growth` per length, no more than `most`? That is noted
    /// then.
    bool is_little(const Condition& c, double least, double growth, double most) const {
        if (!(least >= -allowance(c))) return false;
        if (!(growth > 0) || !(-least / growth <= most)) return false;
        nearer_ = std::max(nearer_, -least / growth);
        return true;
    }

    double allowance(const Condition& c) const { return 2 * error_ + tie_width(c.site); }

    /// Is a site nowhere on a curve nearer than the base by more than the allowance? Along the curve the
    /// excess changes by its gradient times the curve's derivative.
    struct Farther {
        Edges& edges;
        const Net& net;
        double most;  // as of is_little()
        Vector<Interval> box = net.box(), slope = net.derivative(0);
        Vec3 center = middle(box);
        double reach =
            (edges.space().clearance(to_vector<Interval>(center)) + 2 * Interval(radius(box))).upper();

        bool operator()(const Condition& c) {
            const Space<Interval>& space = edges.space();
            // Both distances change by no more than the way.
            if (c.site.is_object() && space.is_beyond(c.site.index, center, reach)) return true;
            if (space.excess(c, box).lower() >= 0) return true;
            const Interval change = dot(space.gradient(c, box), slope);
            const Interval at_begin = space.excess(c, net.corner(0, 0)),
                           at_end = space.excess(c, net.corner(1, 0));
            const double least = std::max((at_begin + Interval(std::min(0.0, change.lower()))).lower(),
                                          (at_end - Interval(std::max(0.0, change.upper()))).lower());
            if (least >= 0) return true;
            return edges.is_little(c, least, edges.growth(c, box), most);
        }
    };

    std::vector<EdgeBound>& bounds_;
    std::vector<Condition> conditions_;                        // the two sites' first
    std::optional<std::array<MiddlePlane, 2>> middle_planes_;  // of its sites, if they have any
    double error_ = 0;               // of the edge under judgement, those of its ends included
    double excess_ = 0;              // of its two sites, at most
    double distance_ = 0;            // what was proved of it
    std::vector<EdgePart> parts_;    // of it, one for each span
    std::vector<Condition> rivals_;  // of the part under judgement
    mutable double nearer_ = 0;      // how far from the boundary a site that is a little nearer leaves it
};

}  // namespace

void certify_edges(const Subject& subject, const CheckOptions& options, Certificate& certificate,
                   std::vector<EdgeBound>& bounds) {
    Edges(subject, options, certificate, bounds).run();
}

}  // namespace vcell::check
