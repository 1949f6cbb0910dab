#include "judged_edge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "excess.hpp"

namespace vcell::check {
namespace {

class EdgeDistance : public Room {
public:
    EdgeDistance(const JudgedEdge& edge, const Subject& subject, const CheckOptions& options,
                 Certificate& certificate)
        : Room(subject, options, certificate), edge_(edge) {}

    std::optional<EdgeBound> follow() {
        const std::vector<EdgePart>& whole = edge_.parts;
        EdgeBound bound{0, 0, 0, HUGE_VAL};
        const double width =
            std::max(tie_width(edge_.conditions[0].site), tie_width(edge_.conditions[1].site));
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
            if (!known || !known->found ||
                !(known->found->distance <= edge_.error + width / known->found->slope))
                known = by_forms(part);
            const auto& [excesses, size, others, found] = *known;
            const double allowed = found ? edge_.error + width / found->slope : 0;
            const double growth = found ? found->growth
                                        : std::min(this->growth(edge_.conditions[0], part.net.box()),
                                                   this->growth(edge_.conditions[1], part.net.box()));
            const bool follows = found && found->distance <= allowed;
            // Where the bisectors touch no place on either is much nearer to the arc than the others.
            const bool touches = !found && part.depth >= JudgedEdge::kTouching && size <= width && growth > 0;
            // Next to a node, in which more than two arcs meet or nearly do, gradients are parallel, too.
            const double from_node =
                follows || touches ? HUGE_VAL : distance_by_node(part.net.box(), size <= width);
            const bool is_by_node = from_node <= edge_.error && growth > 0;
            if ((follows || touches || is_by_node) &&
                others <= 2 * (is_by_node ? edge_.error : allowed) + width) {
                bound.distance = std::max(bound.distance, follows   ? found->distance
                                                          : touches ? size / growth
                                                                    : from_node);
                if (found) bound.rounded = std::max(bound.rounded, width / found->slope);
                bound.excess = std::max(bound.excess, size);
                bound.growth = std::min(bound.growth, growth);
                continue;
            }
            if (off_bisector(part.net, width)) return std::nullopt;
            if (++count > edge_.parts_allowed(options_)) {
                certificate_.leave_open(
                    edge_.path + ".curve",
                    found ? fmt::format("its sites' excesses are below {:.3g}, its error is {:.3g}", size,
                                        edge_.error)
                          : "its sites' bisectors are too nearly parallel",
                    found ? found->distance : HUGE_VAL);
                return std::nullopt;
            }
            for (Net& half : part.net.halves(0))
                parts.push_back(edge_.part(std::move(half), part.depth + 1, space()));
        }
        return bound;
    }

private:
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
        return within_margin(
            [&](double margin) -> std::optional<Reach> {
                const Vector<Interval> x = box_about(box, margin);
                const Vector<Interval> g = space().gradient(edge_.conditions[0], x),
                                       h = space().gradient(edge_.conditions[1], x);
                const Vector<Interval> difference =
                    space().gradient_difference(edge_.conditions[1], edge_.conditions[0], x);
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
                             std::min(growth_of(edge_.conditions[0], g), growth_of(edge_.conditions[1], h))};
            },
            size);
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
        for (std::size_t k = 0; k < edge_.conditions.size(); ++k) {
            const std::optional<Interval> e = excess(edge_.conditions[k]);
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
        if (result.found && result.found->distance <= edge_.error) return result;
        if (const auto apart = along.excess_difference(edge_.conditions[1], edge_.conditions[0]))
            result.found = distance(part.net.box(), result.excesses, result.size, apart);
        if (!edge_.middle_planes || !(part.net.sizes().least_weight > 0)) return result;
        for (const MiddlePlane& plane : *edge_.middle_planes) {
            const auto found = distance_in(plane, part.net, result.excesses[0]);
            if (found && !(result.found && result.found->distance <= found->distance)) result.found = found;
        }
        return result;
    }
    /// As distance(), by the plane and the first site's excess: where both are 0 the second one's is, too.
    std::optional<Reach> distance_in(const MiddlePlane& plane, const Net& net, const Interval& excess) const {
        const Interval off = plane.over(net);
        const double size = sqrt(square(excess) + square(off)).upper();
        return within_margin(
            [&](double margin) -> std::optional<Reach> {
                const Vector<Interval> x = box_about(net.box(), margin);
                const Vector<Interval> g = space().gradient(edge_.conditions[0], x),
                                       h = space().gradient(edge_.conditions[1], x), &n = plane.normal;
                const Interval sine = square(cross(g, n));
                if (!(sine.lower() > 0)) return std::nullopt;
                const double slope = sqrt(sine / (square(g) + square(n))).lower();
                const Interval way = sqrt(square(excess * n - off * g) / sine);
                return Reach{std::min((Interval(size) / slope).upper(), way.upper()), slope,
                             std::min(growth_of(edge_.conditions[0], g), growth_of(edge_.conditions[1], h))};
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
        if (!part.spheres || edge_.conditions[1].site == Site::base()) return std::nullopt;
        std::optional<Distances> result =
            distances([&](const Condition& c) { return part.spheres->excess(c); });
        if (!result) return std::nullopt;
        if (is_box_edge(edge_.conditions[0], edge_.conditions[1]))
            result->found = Reach{result->size, 1, growth_of(edge_.conditions[0], {})};
        else if (!edge_.conditions[0].at_rim && !edge_.conditions[1].at_rim)
            result->found = within_margin(
                [&](double margin) -> std::optional<Reach> {
                    const auto found = part.spheres->slopes(edge_.conditions[0].site,
                                                            edge_.conditions[1].site, result->size, margin);
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
    double distance_by_node(const Vector<Interval>& box, bool is_on_both) const {
        double least = HUGE_VAL;
        for (const std::uint32_t v : cell_.edges[edge_.number].vertices) {
            const CellVertex& end = cell_.vertices[v];
            const Vector<Interval> way = box - to_vector<Interval>(end.point);
            least = std::min(least, (sqrt(square(way)) + Interval(end.error)).upper());
        }
        const bool is_short = radius(box) <= edge_.error && edge_.error <= most_stated(0);
        return is_on_both && is_short ? std::min(least, edge_.error) : least;
    }
    /// Refutes a curve whose end is off one of its bisectors by more than its error.
    bool off_bisector(const Net& net, double width) {
        for (const int end : {0, 1}) {
            const Vector<Interval> p = net.corner(end, 0);
            for (const Condition& c : edge_.conditions) {
                const Interval e = magnitude(space().excess(c, p));
                const Vector<Interval> near = box_about(p, edge_.error);
                const double slope = std::min(2.0, sqrt(square(space().gradient(c, near))).upper());
                if (!(e.lower() > (Interval(slope) * edge_.error + 2 * width).upper())) continue;
                const bool is_nearer = space().excess(c, p).upper() < 0;
                certificate_.refute(edge_.path + ".curve",
                                    fmt::format("{} is {:.3g} {} than the base", title(c.site), e.lower(),
                                                is_nearer ? "nearer" : "farther"),
                                    e.lower() / slope);
                return true;
            }
        }
        return false;
    }

    const JudgedEdge& edge_;
};

}  // namespace

std::optional<EdgeBound> certify_on_arc(const JudgedEdge& edge, const Subject& subject,
                                        const CheckOptions& options, Certificate& certificate) {
    return EdgeDistance(edge, subject, options, certificate).follow();
}

}  // namespace vcell::check
