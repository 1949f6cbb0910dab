#include "judged_edge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "excess.hpp"
#include "tangents.hpp"

namespace vcell::check {
namespace {

class EdgeRivals : public Room {
public:
    EdgeRivals(const JudgedEdge& edge, double distance, const Subject& subject, const CheckOptions& options,
               Certificate& certificate)
        : Room(subject, options, certificate), edge_(edge), distance_(distance) {}

    /// False where a rival is nearer, or may be.
    bool exclude() {
        const std::vector<EdgePart>& whole = edge_.parts;
        struct Task {
            EdgePart part;
            std::vector<Condition> rivals;
        };
        std::vector<Task> tasks;
        std::vector<Condition> rivals;
        for (const EdgePart& p : whole) {
            find_rivals(p, rivals);
            drop_farther(p, rivals);
            if (!rivals.empty()) tasks.push_back({p, rivals});
        }
        std::size_t count = 0;
        while (!tasks.empty()) {
            Task task = std::move(tasks.back());
            tasks.pop_back();
            if (task.part.depth > 0) drop_farther(task.part, task.rivals);
            if (task.rivals.empty()) continue;
            // What gradients over a whole part make of a little at one end of it may be far too much.
            const double most = task.part.depth < JudgedEdge::kTouching ? most_stated(distance_) : HUGE_VAL;
            std::erase_if(task.rivals, Farther{*this, task.part.net, most});
            // A rival that all but ties along the whole edge: polynomials tell that in one part.
            if (count >= kFewParts) {
                const ExcessAlong along(space(), task.part.net);
                std::erase_if(task.rivals, [&](const Condition& c) {
                    double least = along.excess(c).lower();
                    if (least < 0 && count >= kManyParts)
                        least = std::max(least, least_by_tangents(space(), c, task.part.net));
                    if (least >= 0) return true;
                    if (is_farther_than_twin(c, along, task.part.net.box())) return true;
                    if (!ties_at_ends(c) && is_little(c, least, this->growth(c, task.part.net.box()), most))
                        return true;
                    return is_held(c.site, edge_.conditions);
                });
            }
            if (task.rivals.empty()) continue;
            for (const int end : {0, 1})
                for (const Condition& c : task.rivals) {
                    const Interval e = space().excess(c, task.part.net.corner(end, 0));
                    if (!(e.upper() < -allowance(c))) continue;
                    certificate_.refute(
                        edge_.path + ".curve",
                        fmt::format("{} is {:.3g} nearer than the base", title(c.site), -e.upper()),
                        -e.upper());
                    return false;
                }
            if (++count > edge_.parts_allowed(options_)) {
                certificate_.leave_open(edge_.path + ".curve",
                                        fmt::format("{} may be nearer somewhere", title(task.rivals[0].site)),
                                        HUGE_VAL);
                return false;
            }
            for (Net& half : task.part.net.halves(0))
                tasks.push_back({edge_.part(std::move(half), task.part.depth + 1, space()), task.rivals});
        }
        return true;
    }
    double nearer() const { return nearer_; }

private:
    /// Parts after which a rival's gradients are not asked alone.
    static constexpr std::size_t kFewParts = 16;
    /// Parts after which a rival is told by tangents, too.
    static constexpr std::size_t kManyParts = 256;
    /// Is a rival that all but coincides with one of the edge's sites no nearer than that one, but for what
    /// the edge's error makes of what they differ by, and farther somewhere on the edge?
    bool is_farther_than_twin(const Condition& c, const ExcessAlong& along,
                              const Vector<Interval>& box) const {
        return std::ranges::any_of(std::span(edge_.conditions).first(2), [&](const Condition& own) {
            const auto farther = along.excess_difference(c, own);
            if (!farther) return false;
            const auto little = [&](const Vector<Interval>& about) {
                return (sqrt(square(space().gradient_difference(c, own, about))) * Interval(2 * edge_.error))
                    .upper();
            };
            const double growth = this->growth(c, box);
            if (!(farther->lower() >= -little(box)) || !(growth > 0)) return false;
            nearer_ = std::max(nearer_, -farther->lower() / growth);
            return std::ranges::any_of(edge_.parts, [&](const EdgePart& p) {
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
    bool ties_at_ends(const Condition& c) const {
        return std::ranges::all_of(edge_.parts, [&](const EdgePart& p) {
            return std::ranges::all_of(std::array{0, 1}, [&](int end) {
                return !(space().excess(c, p.net.corner(end, 0)).lower() > allowance(c));
            });
        });
    }
    /// Sites beside the edge's own that may be nearer than the base somewhere on the curve.
    void find_rivals(const EdgePart& part, std::vector<Condition>& rivals) const {
        const Vector<Interval>& box = part.net.box();
        const Interval clearance = part.spheres ? part.spheres->clearance() : space().clearance(box);
        Room::rivals(middle(box), (clearance + Interval(radius(box))).upper(), edge_.conditions, rivals);
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
    double allowance(const Condition& c) const { return 2 * edge_.error + tie_width(c.site); }

    /// Is a site nowhere on a curve nearer than the base by more than the allowance? Along the curve the
    /// excess changes by its gradient times the curve's derivative.
    struct Farther {
        EdgeRivals& room;
        const Net& net;
        double most;  // as of is_little()
        Vector<Interval> box = net.box(), slope = net.derivative(0);
        Vec3 center = middle(box);
        double reach =
            (room.space().clearance(to_vector<Interval>(center)) + 2 * Interval(radius(box))).upper();

        bool operator()(const Condition& c) {
            const Space<Interval>& space = room.space();
            // Both distances change by no more than the way.
            if (c.site.is_object() && space.is_beyond(c.site.index, center, reach)) return true;
            if (space.excess(c, box).lower() >= 0) return true;
            const Interval change = dot(space.gradient(c, box), slope);
            const Interval at_begin = space.excess(c, net.corner(0, 0)),
                           at_end = space.excess(c, net.corner(1, 0));
            const double least = std::max((at_begin + Interval(std::min(0.0, change.lower()))).lower(),
                                          (at_end - Interval(std::max(0.0, change.upper()))).lower());
            if (least >= 0) return true;
            return room.is_little(c, least, room.growth(c, box), most);
        }
    };

    const JudgedEdge& edge_;
    double distance_;            // what was proved of it
    mutable double nearer_ = 0;  // how far from the boundary a site that is a little nearer leaves it
};

}  // namespace

std::optional<double> certify_no_rivals(const JudgedEdge& edge, double distance, const Subject& subject,
                                        const CheckOptions& options, Certificate& certificate) {
    EdgeRivals rivals(edge, distance, subject, options, certificate);
    return rivals.exclude() ? std::optional(rivals.nearer()) : std::nullopt;
}

}  // namespace vcell::check
