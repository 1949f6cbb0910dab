#include "traced_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "../../core/errors.hpp"

namespace vcell {

using detail::solve_across;
using detail::turning;

namespace {

/// What is certain of a traced curve in boxes: over which axis it is a graph there, and where it is met.
class CurveGraphs {
protected:
    explicit CurveGraphs(const TracedCurve& curve) : curve_(curve), g_(*curve.g) {
        Interval x(curve.spline.points[0].x()), y(curve.spline.points[0].y());
        for (const auto& p : curve.spline.points) {
            x = hull(x, p.x());
            y = hull(y, p.y());
        }
        size_ = std::max(x.upper() - x.lower(), y.upper() - y.lower());
        scale_ = std::max(x.magnitude(), y.magnitude()) + curve.band;
        closed_ = curve.spline.points.front().head<2>() == curve.spline.points.back().head<2>();
    }

    using Box = std::array<Interval, 2>;
    using Place = std::shared_ptr<const TracedPlace>;

    /// A place on the curve, and of the graph about it the axis and the sign of the derivative of g across
    /// it.
    struct Anchor {
        Place place;
        int along;
        Sign slope;
    };
    /// The line v = v0 + slope (u - u0), u being the coordinate of the axis `along`.
    struct Line {
        int along;
        double u0, v0, slope;
        Interval at(const Interval& u) const { return Interval(v0) + Interval(slope) * (u - Interval(u0)); }
    };

    [[noreturn]] static void fail() {
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "curve",
                         "cannot tell how the curve runs: it has a singular point or a stretch of x = const, "
                         "or the band about an end of it is too wide");
    }

    static Box box_of(const TracedPlace& p) {
        const auto [x, y] = p.enclosure<Interval>();
        return {x, y};
    }
    static bool has_sign(const Interval& i) { return i.lower() > 0 || i.upper() < 0; }
    static bool inside(const Interval& a, const Interval& b) {
        return b.lower() <= a.lower() && a.upper() <= b.upper();
    }
    static bool disjoint(const Interval& a, const Interval& b) {
        return a.upper() < b.lower() || b.upper() < a.lower();
    }

    Interval value(int along, const Interval& u, const Interval& v) const {
        return along == 0 ? g_.value(u, v) : g_.value(v, u);
    }
    std::array<Interval, 2> gradient(const Box& b) const { return g_.jet(b[0], b[1]).gradient; }
    /// The axis along which the curve runs rather than across it.
    int axis_at(const Box& b) const {
        const auto d = gradient(b);
        return std::abs(d[1].mid()) >= std::abs(d[0].mid()) ? 0 : 1;
    }

    // --- Graphs. ---

    /// Is g shown to have the sign all along the line over u? By its mean value form on up to 2^6 parts.
    bool has_sign_along(const Line& line, const Interval& u, Sign sign, int depth = 6) const {
        const Interval middle(u.mid());
        const Interval at_middle = value(line.along, middle, line.at(middle));
        if (at_middle.sign() != sign) return false;
        Box box;
        box[line.along] = u;
        box[1 - line.along] = line.at(u);
        const auto d = gradient(box);
        const Interval derivative = d[line.along] + Interval(line.slope) * d[1 - line.along];
        if ((at_middle + derivative * (u - middle)).sign() == sign) return true;
        return depth > 0 && has_sign_along(line, {u.lower(), u.mid()}, sign, depth - 1) &&
               has_sign_along(line, {u.mid(), u.upper()}, sign, depth - 1);
    }
    /// The sign of the derivative of g across if the curve is a graph in the box.
    std::optional<Sign> graph_slope(int along, const Box& box) const {
        const Interval &u = box[along], &v = box[1 - along];
        const Interval across = gradient(box)[1 - along];
        if (!has_sign(across)) return std::nullopt;
        const Sign slope = *across.sign();
        if (!has_sign_along({along, u.lower(), v.lower(), 0}, u, -slope) ||
            !has_sign_along({along, u.lower(), v.upper(), 0}, u, slope))
            return std::nullopt;
        return slope;
    }
    std::optional<Anchor> anchor(const Eigen::Vector2d& p, double radius) const {
        const int along = axis_at({p.x(), p.y()});
        Box box;
        box[along] = Interval::ball(p[along], radius);
        box[1 - along] = Interval::ball(p[1 - along], 2 * radius);
        const auto slope = graph_slope(along, box);
        if (!slope) return std::nullopt;
        return Anchor{std::make_shared<TracedPlace>(curve_.g, along, p[along], box[1 - along]), along,
                      *slope};
    }

    const TracedCurve& curve_;
    const DefiningFunction& g_;
    double size_ = 0, scale_ = 0;
    bool closed_ = false;
};

/// Walks along the curve from box to box. In each box the curve is a graph over one of the axes: the other
/// derivative of g has no zero there, and g has opposite signs along the two sides that the graph does not
/// cross. So the box holds nothing of {g = 0} but one arc from end to end. Steep boxes, where that axis is y,
/// are then cut where the curve turns in x.
class CurveWalk : CurveGraphs {
public:
    explicit CurveWalk(const TracedCurve& curve) : CurveGraphs(curve) {}

    TracedPieces run() {
        if (closed_) {
            const Place start = some_place();
            walk(start, Sign::Positive, start);
        } else {
            const Eigen::Vector2d first = curve_.spline.evaluate(curve_.spline.domain_begin());
            const Eigen::Vector2d last = curve_.spline.evaluate(curve_.spline.domain_end());
            const auto from = around(first), to = around(last);
            if (!from || !to) fail();
            // Along x the walk runs against the sign of g_y, along y with that of g_x.
            const Sign exit = first_exit(from->along, first[from->along]);
            walk(from->place, from->along == 0 ? -(from->slope * exit) : from->slope * exit, to->place);
        }
        return assemble();
    }

private:
    /// A cell in the direction of the curve, and the turn at its end.
    struct Step {
        TracedGraph::Cell cell;
        bool rightward;
        Place turn;
    };
    static constexpr std::size_t max_steps = std::size_t{1} << 16;  // of a walk that passes by its end

    // --- Where to begin and to end. ---

    // The arc is within a band of each point of the spline. A box that reaches further holds its place there;
    // one within the band about the point holds nothing else. The wider one is a share of the scale at least,
    // so that doubles can tell.
    double unit() const { return std::max(curve_.band, scale_ * 0x1p-30); }
    std::optional<Anchor> around(const Eigen::Vector2d& p) const { return anchor(p, 4.5 * unit()); }
    std::optional<Anchor> beside(const Eigen::Vector2d& p) const {
        Eigen::Vector2d q = p;
        constexpr int newton_steps = 4;
        for (int i = 0; i < newton_steps; ++i) {
            const auto d = gradient({q.x(), q.y()});
            const Eigen::Vector2d normal(d[0].mid(), d[1].mid());
            q -= g_.value(Interval(q.x()), Interval(q.y())).mid() / normal.squaredNorm() * normal;
        }
        // The box's corners are sqrt(5) radii away from q.
        const double radius = (curve_.band - (q - p).norm()) / 3;
        return radius > 0 ? anchor(q, radius) : std::nullopt;
    }

    /// A place on a closed curve where it is not steep.
    Place some_place() const {
        const RationalCurve2& s = curve_.spline;
        constexpr int parts = 16;  // of each knot span
        for (std::size_t i = 0; i + 1 < s.knots.size(); ++i) {
            if (s.knots[i] == s.knots[i + 1]) continue;
            for (int k = 0; k < parts; ++k) {
                const Eigen::Vector2d p =
                    s.evaluate(std::lerp(s.knots[i], s.knots[i + 1], static_cast<double>(k) / parts));
                auto found = around(p);
                if (!found) found = beside(p);
                if (found && found->along == 0) return found->place;
            }
        }
        fail();
    }

    /// Where does the spline leave the neighbourhood of its first point, forward or backward along the axis?
    /// It gets 2.5 units away on one side and not yet 3.5 on the other; the arc, a graph over more than 4.5,
    /// is with it, on that side of its own end.
    Sign first_exit(int along, double from) const {
        const auto& knots = curve_.spline.knots;
        for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
            if (knots[i] == knots[i + 1]) continue;
            const Sign exit = first_exit(along, from, knots[i], knots[i + 1]);
            if (exit != Sign::Zero) return exit;
        }
        fail();
    }
    Sign first_exit(int along, double from, double begin, double end) const {
        const auto points = control_points(begin, end);
        Interval u = points[0][along];
        for (const auto& p : points) u = hull(u, p[along]);
        u -= Interval(from);
        if (inside(u, Interval::ball(0, 3.25 * unit()))) return Sign::Zero;
        if (u.lower() > 2.5 * unit()) return Sign::Positive;
        if (u.upper() < -2.5 * unit()) return Sign::Negative;
        const double middle = std::midpoint(begin, end);
        if (!(begin < middle && middle < end)) fail();
        const Sign exit = first_exit(along, from, begin, middle);
        return exit != Sign::Zero ? exit : first_exit(along, from, middle, end);
    }
    /// The control points over [from, to] within one knot span, by the blossom of the homogeneous spline.
    std::vector<Box> control_points(double from, double to) const {
        const RationalCurve2& s = curve_.spline;
        const auto n = static_cast<std::size_t>(s.degree);
        // The span [knots[j], knots[j + 1]) that holds `from`.
        const auto j = static_cast<std::size_t>(std::upper_bound(s.knots.begin(), s.knots.end(), from) -
                                                s.knots.begin() - 1);
        std::vector<Box> result;
        for (std::size_t k = 0; k <= n; ++k) {
            std::vector<std::array<Interval, 3>> d;
            for (std::size_t i = j - n; i <= j; ++i) {
                const auto& p = s.points[i];
                d.push_back(
                    {Interval(p[0]) * Interval(p[2]), Interval(p[1]) * Interval(p[2]), Interval(p[2])});
            }
            for (std::size_t r = 1; r <= n; ++r) {
                const Interval u(r <= k ? to : from);
                for (std::size_t i = n; i >= r; --i) {
                    const Interval t0(s.knots[j - n + i]), t1(s.knots[j + 1 + i - r]);
                    const Interval a = (u - t0) / (t1 - t0);
                    for (int axis = 0; axis < 3; ++axis)
                        d[i][axis] = (Interval(1.0) - a) * d[i - 1][axis] + a * d[i][axis];
                }
            }
            result.push_back({d[n][0] / d[n][2], d[n][1] / d[n][2]});
        }
        return result;
    }

    // --- The walk. ---

    /// Along orientation * (-g_y, g_x).
    void walk(Place from, Sign orientation, const Place& target) {
        const double least = scale_ * 0x1p-40;  // below, doubles hardly tell
        double length = size_ / 16;
        for (std::size_t i = 0; i < max_steps; ++i) {
            const Box start = box_of(*from);
            const int along = axis_at(start);
            bool at_once = true;
            for (;; length /= 2, at_once = false) {
                if (length < least) fail();
                // A closed walk begins at its target.
                if (const Place to =
                        advance(from, start, along, orientation, length, target, closed_ && i == 0)) {
                    if (to == target) return;
                    from = to;
                    break;
                }
            }
            if (at_once) length = std::min(2 * length, size_ / 8);
        }
        fail();
    }

    /// Appends the part of the curve in a box of that length and returns its end, `target` if that is in it.
    /// None: the box must be shorter.
    Place advance(const Place& from, const Box& start, int along, Sign orientation, double length,
                  const Place& target, bool at_target) {
        const auto d = gradient(start);
        const Sign slope = sign_of(d[1 - along].mid());
        const bool forward = (along == 0 ? -(orientation * slope) : orientation * slope) == Sign::Positive;
        const double step = forward ? length : -length;
        const Interval &u = start[along], &v = start[1 - along];
        const double end = (forward ? u.upper() : u.lower()) + step;
        const double tangent = -d[along].mid() / d[1 - along].mid();
        Box box;
        box[along] = hull(u, end);
        box[1 - along] = hull(v, v.mid() + tangent * step) + Interval::ball(0, length / 4);
        if (graph_slope(along, box) != slope) return nullptr;

        Place to;
        const Box there = box_of(*target);
        if (!at_target && !disjoint(there[0], box[0]) && !disjoint(there[1], box[1])) {
            const bool ahead = forward ? u.upper() < there[along].lower() : there[along].upper() < u.lower();
            if (!ahead || !inside(there[0], box[0]) || !inside(there[1], box[1])) return nullptr;
            to = target;
            box[along] = hull(u, there[along]);
        } else {
            to = std::make_shared<TracedPlace>(curve_.g, along, end, box[1 - along]);
        }
        if (along == 0) {
            add_flat(box, slope, from, to, forward);
            return to;
        }
        return add_steep(box, slope, from, to, forward, to == target) ? to : nullptr;
    }

    static void place_ends(TracedGraph::Cell& cell, const Place& left, const Place& right) {
        cell.left = left;
        cell.right = right;
        cell.x0 = left->coordinate<Interval>(0).lower();
        cell.x1 = right->coordinate<Interval>(0).upper();
    }

    void add_flat(const Box& box, Sign above, const Place& from, const Place& to, bool rightward) {
        TracedGraph::Cell cell{.box_x = box[0], .y = box[1], .above = above, .left = {}, .right = {}};
        place_ends(cell, rightward ? from : to, rightward ? to : from);
        set_band(cell);
        steps_.push_back({cell, rightward, nullptr});
    }

    // A band about the chord, shown by the signs of g along its rims.
    void set_band(TracedGraph::Cell& cell) const {
        const auto height = [&](double x) {
            return solve_across<Interval>(g_, 0, Interval(x), cell.y, cell.above).mid();
        };
        const Interval x(cell.x0, cell.x1);
        const double y0 = height(x.lower()), slope = (height(x.upper()) - y0) / (x.upper() - x.lower());
        const double sag = std::abs(height(x.mid()) - y0 - slope * (x.mid() - x.lower()));
        double band = 1.5 * sag + scale_ * 0x1p-40;
        constexpr int max_doublings = 3;
        for (int i = 0; i <= max_doublings; ++i, band *= 2) {
            if (!has_sign_along({0, cell.x0, y0 - band, slope}, x, -cell.above) ||
                !has_sign_along({0, cell.x0, y0 + band, slope}, x, cell.above))
                continue;
            cell.y0 = y0;
            cell.slope = slope;
            cell.band = band * (1 + 0x1p-40);  // the rims' heights are rounded
            return;
        }
        set_wide_band(cell);
    }
    static void set_wide_band(TracedGraph::Cell& cell) {
        cell.y0 = cell.y.mid();
        cell.slope = 0;
        cell.band = cell.y.upper() - cell.y.lower();
    }

    // --- Turns. ---

    /// A height with the sign of g_y there on the curve; Zero: not known.
    template <class T>
    struct Node {
        T y;
        Sign sign;
    };
    /// Isolates the turns of the curve in a steep box, upwards.
    struct Turns {
        Interval box_x;
        Sign g_x;
        std::vector<Place> found;
    };

    Sign sign_at(const TracedPlace& p) const {
        const auto [x, y] = p.enclosure<Interval>();
        if (const auto s = g_.jet(x, y).gradient[1].sign(); s && *s != Sign::Zero) return *s;
        const auto [fine_x, fine_y] = p.enclosure<Wide>();
        return g_.jet(fine_x, fine_y).gradient[1].sign().value_or(Sign::Zero);
    }

    /// False where `to`, an arbitrary place, happens to be at a turn as far as one can tell.
    bool add_steep(const Box& box, Sign g_x, const Place& from, const Place& to, bool upward,
                   bool at_target) {
        const Place &low = upward ? from : to, &high = upward ? to : from;
        const Sign at_low = sign_at(*low), at_high = sign_at(*high);
        if (!at_target && (upward ? at_high : at_low) == Sign::Zero) return false;
        if (at_low == Sign::Zero && at_high == Sign::Zero) fail();
        for (const auto& [sign, place] : {std::pair(at_low, low), std::pair(at_high, high)}) {
            if (sign == Sign::Zero) assume(box_of(*place));
        }
        Turns turns{box[0], g_x, {}};
        find_turns<Interval>(turns, {low->coordinate<Interval>(1), at_low},
                             {high->coordinate<Interval>(1), at_high});

        std::vector<Place> places{low};
        places.insert(places.end(), turns.found.begin(), turns.found.end());
        places.push_back(high);
        const bool odd = turns.found.size() % 2 == 1;
        Sign above = at_low != Sign::Zero ? at_low : odd ? -at_high : at_high;
        std::vector<Step> steps;
        for (std::size_t i = 0; i + 1 < places.size(); ++i, above = -above) {
            const Place &lower = places[i], &upper = places[i + 1];
            const Sign rising = -(above * g_x);
            TracedGraph::Cell cell{.box_x = box[0],
                                   .y = hull(lower->coordinate<Interval>(1), upper->coordinate<Interval>(1)),
                                   .above = above,
                                   .rising = rising,
                                   .left = {},
                                   .right = {}};
            const bool rises = rising == Sign::Positive;
            place_ends(cell, rises ? lower : upper, rises ? upper : lower);
            set_wide_band(cell);
            const Place end = upward ? upper : lower;
            steps.push_back({cell, rises == upward, end == to ? nullptr : end});
        }
        if (!upward) std::reverse(steps.begin(), steps.end());
        steps_.insert(steps_.end(), steps.begin(), steps.end());
        return true;
    }

    template <class T>
    void find_turns(Turns& turns, const Node<T>& l, const Node<T>& r) {
        const auto x_at = [&](const T& y) { return solve_across(g_, 1, y, turns.box_x, turns.g_x); };
        const T y = hull(l.y, r.y), x = x_at(y);
        const bool changes = l.sign == -r.sign;
        const auto add = [&](Sign beyond) {
            turns.found.push_back(std::make_shared<TracedPlace>(curve_.g, turns.box_x, Wide(y), beyond));
        };
        const auto known = [](const T& t) { return t.lower() > 0 || t.upper() < 0; };
        if (known(g_.jet(x, y).gradient[1])) return;
        if (known(turning(g_.second_jet(x, y)))) {
            if (changes) add(r.sign);
            return;
        }
        const double narrow = scale_ * (std::is_same_v<T, Interval> ? 0x1p-44 : assumed_width);
        if (y.upper() - y.lower() > narrow) {
            // Off the middle when a turn lies too near to it.
            for (const double share : {0.5, 0.40625, 0.625}) {
                const T from(l.y.upper(), l.y.upper()), to(r.y.lower(), r.y.lower());
                const T middle((from + T(share) * (to - from)).mid());
                if (!(from.upper() < middle.lower() && middle.upper() < to.lower())) break;
                const auto sign = g_.jet(x_at(middle), middle).gradient[1].sign();
                if (!sign || *sign == Sign::Zero) continue;
                const Node<T> node{middle, *sign};
                find_turns(turns, l, node);
                find_turns(turns, node, r);
                return;
            }
        }
        if constexpr (std::is_same_v<T, Interval>) {
            find_turns<Wide>(turns, {Wide(l.y), l.sign}, {Wide(r.y), r.sign});
        } else {
            if (changes) add(Sign::Zero);
            assume({x.enclosure(), y.enclosure()});
        }
    }

    void assume(const Box& box) { assumed_.emplace_back(box[0].mid(), box[1].mid()); }

    // --- Pieces. ---

    TracedPieces assemble() {
        Place from = steps_.front().rightward ? steps_.front().cell.left : steps_.front().cell.right;
        const Place end = steps_.back().rightward ? steps_.back().cell.right : steps_.back().cell.left;
        if (closed_) {
            const auto turn =
                std::find_if(steps_.begin(), steps_.end(), [](const Step& s) { return s.turn != nullptr; });
            if (turn == steps_.end()) fail();
            from = turn->turn;
            std::rotate(steps_.begin(), turn + 1, steps_.end());
        }
        TracedPieces result;
        for (std::size_t i = 0; i < steps_.size();) {
            TracedPiece piece;
            piece.graph.g = curve_.g;
            const bool rightward = steps_[i].rightward;
            Place to = end;
            for (bool go_on = true; go_on && i < steps_.size(); ++i) {
                if (steps_[i].rightward != rightward)
                    throw InternalError("a traced curve turns back between its turns");
                piece.graph.cells.push_back(steps_[i].cell);
                if (steps_[i].turn) {
                    to = steps_[i].turn;
                    go_on = false;
                }
            }
            if (!rightward) std::reverse(piece.graph.cells.begin(), piece.graph.cells.end());
            piece.left = rightward ? from : to;
            piece.right = rightward ? to : from;
            from = to;
            result.pieces.push_back(std::move(piece));
        }
        result.assumed = std::move(assumed_);
        return result;
    }

    std::vector<Step> steps_;
    std::vector<Eigen::Vector2d> assumed_;
};

}  // namespace

TracedPieces cut_traced_curve(const TracedCurve& curve) { return CurveWalk(curve).run(); }

}  // namespace vcell
