#include "edges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "excess.hpp"

namespace vcell::check {
namespace {

struct Part {
    Net net;
    int depth = 0;
};

/// The clearance along a span as a rational function with the span's weights, within an error.
struct RationalClearance {
    SmallVector<double, 4> coefficients;
    double error;
    Interval range;

    /// Over a plane it is one. From a centre it is one along conics that two bisectors of balls have in
    /// common: then the one that agrees with it at three places agrees with it everywhere, which its square
    /// tells.
    static std::optional<RationalClearance> along(const Net& net, const Space<Interval>& space) {
        const Surface<Interval>& base = space.base();
        using Kind = Surface<Interval>::Kind;
        const int n = net.degree_s();
        if (base.kind == Kind::cylinder || (base.kind == Kind::sphere && n != 2)) return std::nullopt;
        Vector<MidRad> way;  // from the base's point to the origin
        for (std::size_t k = 0; k < 3; ++k)
            way[k] = MidRad(net.origin()[static_cast<Eigen::Index>(k)]) - MidRad(base.point[k]);
        std::array<SmallVector<MidRad, 4>, 3> from_base;
        for (std::size_t k = 0; k < 3; ++k)
            for (int i = 0; i <= n; ++i) from_base[k].push_back(net.at(i, 0)[k] + way[k] * net.at(i, 0)[3]);
        RationalClearance result{{}, 0, 0.0};
        if (base.kind == Kind::plane) {
            double least = HUGE_VAL, most = -HUGE_VAL;
            for (int i = 0; i <= n; ++i) {
                const MidRad w = net.at(i, 0)[3];
                MidRad height = 0.0;
                for (std::size_t k = 0; k < 3; ++k) height += MidRad(base.direction[k]) * from_base[k][i];
                result.coefficients.push_back(height.mid());
                result.error = std::max(result.error, (MidRad::ball(0, height.radius()) / w).magnitude());
                least = std::min(least, (height / w).lower());
                most = std::max(most, (height / w).upper());
            }
            if (!(most - least < HUGE_VAL)) return std::nullopt;
            result.range = {least, most};
            return result;
        }
        const double radius = base.radius.mid();
        const auto homogeneous = [&](double a, double b,
                                     double c) {  // the distance from the centre, times the weight
            double sum = 0;
            for (const auto& x : from_base)
                sum += std::pow(a * x[0].mid() + b * x[1].mid() + c * x[2].mid(), 2);
            return std::sqrt(sum);
        };
        const double first = homogeneous(1, 0, 0), last = homogeneous(0, 0, 1),
                     middle = 2 * homogeneous(0.25, 0.5, 0.25) - 0.5 * (first + last);
        Form distance(2, 0), weight(2, 0), square_of_way(4, 0);
        const std::array<double, 3> distances{first, middle, last};
        double rounding = 0;
        for (int i = 0; i <= 2; ++i) {
            const MidRad& w = net.at(i, 0)[3];
            distance.set(i, 0, distances[static_cast<std::size_t>(i)]);
            weight.set(i, 0, w);
            const MidRad clearance = distances[static_cast<std::size_t>(i)] - radius * w;
            result.coefficients.push_back(clearance.mid());
            rounding = std::max(rounding, (MidRad::ball(0, clearance.radius()) / w).magnitude());
        }
        for (const auto& x : from_base) {
            Form f(2, 0);
            for (int i = 0; i <= 2; ++i) f.set(i, 0, x[static_cast<std::size_t>(i)]);
            square_of_way = square_of_way + square(f);
        }
        // |p| - q with q the rational function: (p^2 - q^2) / (|p| + q).
        const Interval w = weight.range(), q = distance.range() / w,
                       off = (square_of_way - square(distance)).range() / square(w);
        if (!(q.lower() > 0) || !(off.magnitude() < HUGE_VAL)) return std::nullopt;
        result.error = Interval::up((off / q).magnitude() + rounding);
        result.range = q - base.radius + Interval(-result.error, result.error);
        return result;
    }
};

class Edges : public Room {
public:
    using Room::Room;

    std::vector<EdgeBound> run() {
        bounds_.resize(cell_.edges.size());
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) judge(i);
        return std::move(bounds_);
    }

private:
    void judge(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        const std::string where = edge_path(i);
        if (e.sites[0] == e.sites[1] && !rim_[i])
            return certificate_.refute(where + ".sites", fmt::format("are {} twice", title(e.sites[0])));
        if (!check_ends(i)) return;
        conditions_.clear();
        for (const Site& s : label(i)) conditions_.push_back({s, geometry_.is_plane() && rim_[i] == s});
        // A side of the box may lean out of its own rim: it meets the boundary there.
        if (e.sites[0] == e.sites[1]) conditions_.push_back({e.sites[0]});
        const auto is_first = [&](const Condition& c) { return contains(e.sites, c.site); };
        std::ranges::stable_partition(conditions_, is_first);

        const Vec3 origin = e.curve.points.front().head<3>();
        std::vector<Part> parts;
        for (const auto& span : spans<3>(e.curve, origin)) parts.push_back({Net(span, origin)});
        error_ = full_error(i);
        EdgeBound bound{0, 0, HUGE_VAL};
        if (!follow_arc(where, parts, bound)) return;
        nearer_ = 0;
        excess_ = bound.excess;
        distance_ = bound.distance;
        if (!exclude_others(where, parts)) return;
        if (e.error > most_stated(bound.distance))
            return certificate_.refute(
                where + ".error",
                fmt::format("is {:.3g}, the curve is within {:.3g} of the true one", e.error, bound.distance),
                e.error);
        bounds_[i] = bound;
        prove(where, std::max(bound.distance, nearer_));
    }

    bool check_ends(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        const auto& curve = edge_pieces_[i];
        const std::array ends{curve.front().evaluate(curve.front().begin)[0],
                              curve.back().evaluate(curve.back().end)[0]};
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

    // --- On the arc ---------------------------------------------------------------------------------

    struct Reach {
        double distance, slope;  ///< the least singular value that far around
        double growth;           ///< the lesser of both excesses', as growth() has it
    };
    /// What a bound on the excesses says about the distance from the arc, or nothing where gradients are
    /// parallel in the box.
    std::optional<Reach> distance(const Vector<Interval>& box, double size) const {
        double margin = kFirstMargin * size;
        for (int tries = 0; tries < 4; ++tries) {
            const Interval m(-margin, margin);
            const Vector<Interval> x{box[0] + m, box[1] + m, box[2] + m};
            const Vector<Interval> g = space().gradient(conditions_[0], x),
                                   h = space().gradient(conditions_[1], x);
            const Vector<Interval> difference = space().gradient_difference(conditions_[1], conditions_[0], x);
            const Interval sine = square(cross(g, difference)), sum = square(g) + square(h);
            if (!(sine.lower() > 0)) return std::nullopt;
            // Of a matrix with rows g and h: |g x h|^2 is the product of the squared singular values, of
            // which the greater is below the sum of squares.
            const double slope = sqrt(sine / sum).lower();
            const double reach = (Interval(size) / slope).upper();
            if (reach <= margin)
                return Reach{reach, slope,
                             std::min(growth_of(conditions_[0], g), growth_of(conditions_[1], h))};
            margin = 1.25 * reach;
        }
        return std::nullopt;
    }

    bool follow_arc(const std::string& where, const std::vector<Part>& whole, EdgeBound& bound) {
        const double width = std::max(tie_width(conditions_[0].site), tie_width(conditions_[1].site));
        std::vector<Part> parts = whole;
        std::size_t count = 0;
        while (!parts.empty()) {
            const Part part = std::move(parts.back());
            parts.pop_back();
            const ExcessAlong along(space(), part.net);
            Interval squares(0.0), others(0.0);
            for (std::size_t k = 0; k < conditions_.size(); ++k) {
                const Interval e = along.excess(conditions_[k]);
                if (k < 2)
                    squares += square(e);
                else
                    others = hull(others, magnitude(e));
            }
            const double size = sqrt(squares).upper();
            const Vector<Interval>& box = part.net.box();
            const auto found = distance(box, size);
            const double allowed = found ? error_ + width / found->slope : 0;
            const double growth =
                found ? found->growth
                      : std::min(this->growth(conditions_[0], box), this->growth(conditions_[1], box));
            const bool follows = found && found->distance <= allowed;
            // Where the bisectors touch no place on either is much nearer to the arc than the others.
            const bool touches = !found && part.depth >= kTouching && size <= width && growth > 0;
            if ((follows || touches) && others.upper() <= 2 * allowed + width) {
                bound.distance = std::max(bound.distance, follows ? found->distance : size / growth);
                bound.excess = std::max(bound.excess, size);
                bound.growth = std::min(bound.growth, growth);
                continue;
            }
            if (off_bisector(where, part.net, width)) return false;
            if (++count > parts_allowed()) {
                certificate_.leave_open(
                    where + ".curve",
                    found ? fmt::format("its sites' excesses are below {:.3g}, its error is {:.3g}", size,
                                        error_)
                          : "its sites' bisectors are too nearly parallel",
                    found ? found->distance : HUGE_VAL);
                return false;
            }
            for (const Net& half : part.net.halves(0)) parts.push_back({half, part.depth + 1});
        }
        return true;
    }

    /// Halvings after which gradients that are still parallel somewhere are taken to be so at a point.
    static constexpr int kTouching = 12;

    std::size_t parts_allowed() const { return std::size_t{1} << std::clamp(options_.effort, 0, 40); }

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

    bool exclude_others(const std::string& where, const std::vector<Part>& whole) {
        struct Task {
            Net net;
            std::vector<Condition> rivals;
            int depth;
        };
        std::vector<Task> tasks;
        for (const Part& p : whole) {
            std::vector<Condition> found = rivals(p.net);
            drop_balls(p.net, found);
            if (!found.empty()) tasks.push_back({p.net, std::move(found), 0});
        }
        std::size_t count = 0;
        while (!tasks.empty()) {
            Task task = std::move(tasks.back());
            tasks.pop_back();
            std::erase_if(task.rivals, Farther{*this, task.net});
            if (task.rivals.empty()) continue;
            for (const int end : {0, 1})
                for (const Condition& c : task.rivals) {
                    const Interval e = space().excess(c, task.net.corner(end, 0));
                    if (!(e.upper() < -allowance(c))) continue;
                    certificate_.refute(
                        where + ".curve",
                        fmt::format("{} is {:.3g} nearer than the base", title(c.site), -e.upper()),
                        -e.upper());
                    return false;
                }
            if (++count > parts_allowed()) {
                certificate_.leave_open(where + ".curve",
                                        fmt::format("{} may be nearer somewhere", title(task.rivals[0].site)),
                                        HUGE_VAL);
                return false;
            }
            auto halves = task.net.halves(0);
            tasks.push_back({std::move(halves[0]), task.rivals, task.depth + 1});
            tasks.push_back({std::move(halves[1]), std::move(task.rivals), task.depth + 1});
        }
        return true;
    }

    /// Sites beside the edge's own that may be nearer than the base somewhere on the curve.
    std::vector<Condition> rivals(const Net& net) const {
        const Vector<Interval>& box = net.box();
        return Room::rivals(middle(box), (space().clearance(box) + Interval(radius(box))).upper(),
                            conditions_);
    }

    /// Drops rival balls that are farther than a ball o of the edge's own all along a span, if the clearance
    /// t is a rational function of its degree there.
    ///
    /// With p from o's centre and d the way to the rival's, |p - d|^2 - (t + rho_r)^2 has the sign of the
    /// rival's excess. Where o's own is e, |p| = t + rho_o + e, that is
    ///     d^2 - 2 p d + (rho_o - rho_r) (2 t + rho_o + rho_r) + e (2 t + 2 rho_o + e),
    /// linear in p and t.
    void drop_balls(const Net& net, std::vector<Condition>& rivals) const {
        const auto ball = [&](const Condition& c) {
            return c.site.is_object() ? std::get_if<Sphere>(&scene_.objects[c.site.index]) : nullptr;
        };
        const Sphere* own = nullptr;
        for (std::size_t k = 0; k < 2 && !own; ++k) own = ball(conditions_[k]);
        if (!own || std::ranges::none_of(rivals, ball)) return;
        const auto clearance = RationalClearance::along(net, space());
        if (!clearance) return;
        const Interval own_radius(own->radius), t = clearance->range;
        const Interval e(-excess_, excess_);
        const Interval rest = e * (2.0 * (t + own_radius) + e);
        const int n = net.degree_s();
        SmallVector<Net::Point, 4> from_own;  // homogeneous coordinates about the own centre
        for (int i = 0; i <= n; ++i) {
            Net::Point p = net.at(i, 0);
            for (std::size_t k = 0; k < 3; ++k) {
                const auto axis = static_cast<Eigen::Index>(k);
                p[k] = p[k] + (MidRad(net.origin()[axis]) - own->center[axis]) * p[3];
            }
            from_own.push_back(p);
        }
        const Vector<Interval>& box = net.box();
        std::erase_if(rivals, [&](const Condition& c) {
            const Sphere* rival = ball(c);
            if (!rival) return false;
            Vector<MidRad> way;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto axis = static_cast<Eigen::Index>(k);
                way[k] = MidRad(rival->center[axis]) - own->center[axis];
            }
            const MidRad difference = MidRad(own->radius) - rival->radius,
                         sum = MidRad(own->radius) + rival->radius;
            const MidRad constant = square(way) + difference * sum, twice = 2.0 * difference;
            // The least Bernstein coefficient, over its weight.
            double least = HUGE_VAL;
            for (int i = 0; i <= n; ++i) {
                const Net::Point& p = from_own[i];
                const MidRad value = constant * p[3] + twice * clearance->coefficients[i] -
                                     2.0 * (way[0] * p[0] + way[1] * p[1] + way[2] * p[2]);
                const double quotient = (value / p[3]).lower();
                if (!(quotient >= least)) least = quotient;
            }
            const Interval margin = rest + twice.enclosure() * Interval(-clearance->error, clearance->error);
            least = (Interval(least) + margin).lower();
            if (least >= 0) return true;
            const Interval reach =
                space().object_excess(c.site.index, box, Interval(0.0)) + 2 * Interval(rival->radius) + t;
            if (!(reach.lower() > 0)) return false;
            // No more than the curve itself may be off: else a finer look is worth while.
            return is_little(c, box, (Interval(least) / reach.lower()).lower(), distance_);
        });
    }
    /// Is an excess that is no less than `least`, which is negative, within the allowance, and is what that
    /// means for the boundary no more than `most`? That is noted then.
    bool is_little(const Condition& c, const Vector<Interval>& box, double least, double most) const {
        if (!(least >= -allowance(c))) return false;
        const double growth = this->growth(c, box);
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
            return edges.is_little(c, box, least, HUGE_VAL);
        }
    };

    std::vector<EdgeBound> bounds_;
    std::vector<Condition> conditions_;  // the two sites' first
    double error_ = 0;                   // of the edge under judgement, those of its ends included
    double excess_ = 0;                  // of its two sites, at most
    double distance_ = 0;                // what was proved of it
    mutable double nearer_ = 0;          // how far from the boundary a site that is a little nearer leaves it
};

}  // namespace

std::vector<EdgeBound> certify_edges(const Subject& subject, const CheckOptions& options,
                                     Certificate& certificate) {
    return Edges(subject, options, certificate).run();
}

}  // namespace vcell::check
