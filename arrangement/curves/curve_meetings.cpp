// CurveArcs where two branches meet: the zeros of the difference of their heights are isolated, once for each
// pair, and all questions about the pair are answered from these and from the signs between them.
#include <algorithm>
#include <array>
#include <type_traits>

#include "../../core/solver/newton/one_unknown.hpp"
#include "curve_arcs.hpp"

namespace vcell {

namespace {

template <class T>
bool excludes_zero(const T& t) {
    return t.lower() > 0 || t.upper() < 0;
}

// Below this share of the scale of the coordinates a coincidence is assumed.
constexpr double assumed_width = 0x1p-200;

Interval in_doubles(const Interval& i) { return i; }
Interval in_doubles(const Wide& i) { return i.enclosure(); }

}  // namespace

std::optional<CurveArcs::Point> CurveArcs::later_left(BranchId a, BranchId b) {
    const Point p = branches_[a].left, q = branches_[b].left;
    if (!p.valid() || !q.valid())
        return p.valid() ? std::optional(p) : q.valid() ? std::optional(q) : std::nullopt;
    return points_.compare_x(p, q) == Sign::Negative ? q : p;
}

std::optional<CurveArcs::Point> CurveArcs::earlier_right(BranchId a, BranchId b) {
    const Point p = branches_[a].right, q = branches_[b].right;
    if (!p.valid() || !q.valid())
        return p.valid() ? std::optional(p) : q.valid() ? std::optional(q) : std::nullopt;
    return points_.compare_x(p, q) == Sign::Positive ? q : p;
}

Sign CurveArcs::sign_between(BranchId a, BranchId b, std::optional<Point> l, std::optional<Point> r) {
    const MonotoneGraph &f = *branches_[a].graph, &g = *branches_[b].graph;
    const auto between = [&]<class T>(const T& from, const T& to) -> std::optional<Sign> {
        const T middle((T(0.5) * (T(from.upper(), from.upper()) + T(to.lower(), to.lower()))).mid());
        if (!(from.upper() < middle.lower() && middle.upper() < to.lower())) return std::nullopt;
        return (f.y(middle) - g.y(middle)).sign();
    };
    const auto next_to = [](const auto& p, double way) { return p + std::decay_t<decltype(p)>(way); };
    const auto sample = [&](const auto& left, const auto& right) -> std::optional<Sign> {
        using T = std::decay_t<decltype(*left)>;
        if (left && right) return between(*left, *right);
        const double far = 2 + 2 * (left    ? in_doubles(*left)
                                    : right ? in_doubles(*right)
                                            : Interval())
                                       .magnitude();
        if (left) return between(*left, next_to(*left, far));
        if (right) return between(next_to(*right, -far), *right);
        return between(T(-1.0), T(1.0));
    };
    const auto rough = [&](std::optional<Point> p) {
        return p ? std::optional(points_[*p].x) : std::nullopt;
    };
    if (const auto s = sample(rough(l), rough(r)); s && *s != Sign::Zero) {
        ++points_.decisions().by_interval;
        return *s;
    }
    const auto fine = [&](std::optional<Point> p) {
        return p ? std::optional(points_.fine_box(*p).first) : std::nullopt;
    };
    const auto s = sample(fine(l), fine(r));
    if (s && *s != Sign::Zero) {
        ++points_.decisions().by_multiprecision;
        return *s;
    }
    const Point at = l ? *l : *r;
    points_.assume(points_[at].x, points_[at].y);
    return Sign::Zero;
}

CurveArcs::Meeting CurveArcs::with_signs_between(BranchId a, BranchId b, std::vector<Point> points) {
    const auto first = later_left(a, b), last = earlier_right(a, b);
    Meeting m{false, std::move(points), {}};
    m.signs.assign(m.points.size() + 1, Sign::Zero);
    if (first && last && points_.compare_x(*first, *last) != Sign::Negative) return m;
    for (std::size_t i = 0; i <= m.points.size(); ++i) {
        const auto l = i == 0 ? first : m.points[i - 1];
        const auto r = i == m.points.size() ? last : m.points[i];
        if (l && r && points_.compare_x(*l, *r) != Sign::Negative) continue;
        m.signs[i] = sign_between(a, b, l, r);
    }
    return m;
}

/// Finds the common points of two branches that are no vertical lines.
class CurveArcs::Isolation {
public:
    Isolation(CurveArcs& arcs, BranchId a, BranchId b)
        : m_(arcs),
          points_(arcs.points_),
          a_(a),
          b_(b),
          f_(arcs.branches_[a].graph),
          g_(arcs.branches_[b].graph) {}

    Meeting run() {
        // One of the branches is bounded: two lines meet exactly.
        const Point first = m_.later_left(a_, b_).value(), last = m_.earlier_right(a_, b_).value();
        const Sign order = points_.compare_x(first, last);
        if (order == Sign::Positive) return {false, {}, {Sign::Zero}};
        const Sign left = difference_at(first);
        if (order == Sign::Zero) {
            if (left == Sign::Zero) return {false, {first}, {Sign::Zero, Sign::Zero}};
            return {false, {}, {left}};
        }
        const Sign right = difference_at(last);
        result_.signs.push_back(left);
        if (left == Sign::Zero) result_.points.push_back(first);
        first_ = first;
        last_ = last;
        section<Interval>({points_[first].x, left}, {points_[last].x, right});
        if (result_.coincide) return {true, {}, {}};
        if (right == Sign::Zero) {
            result_.points.push_back(last);
            result_.signs.push_back(Sign::Zero);
        }
        return std::move(result_);
    }

private:
    /// A place in the common range with the sign of the difference there; Zero: a common point at its end.
    template <class T>
    struct Node {
        T x;
        Sign sign;
    };

    Sign difference_at(Point p) {
        return points_.is_known_on(p, a_) ? m_.side_of(p, b_) : -m_.side_of(p, a_);
    }

    template <class T>
    T difference(const T& x) const {
        return f_->y(x) - g_->y(x);
    }
    template <class T>
    void count() {
        ++(std::is_same_v<T, Interval> ? points_.decisions().by_interval
                                       : points_.decisions().by_multiprecision);
    }

    // The slopes of the graphs differ in order all over x, or one of them falls where the other rises.
    template <class T>
    bool is_monotone(const T& x) const {
        const Direction<T> d = f_->direction(x), e = g_->direction(x);
        if (excludes_zero(T(d.dx * e.dy - d.dy * e.dx))) return true;
        return (d.dy.lower() > 0 && e.dy.upper() < 0) || (d.dy.upper() < 0 && e.dy.lower() > 0);
    }

    template <class T>
    void section(const Node<T>& l, const Node<T>& r) {
        const T x = hull(l.x, r.x);
        const bool common_end = l.sign == Sign::Zero || r.sign == Sign::Zero;
        if (!common_end) {
            if (excludes_zero(difference(x))) {
                count<T>();
                return close(r.sign);
            }
        }
        if (is_monotone(x) && (l.sign != Sign::Zero || r.sign != Sign::Zero)) {
            count<T>();
            if (l.sign == -r.sign && !common_end) add_crossing(l, r);
            return close(r.sign);
        }
        if (is_negligible(x)) {
            if constexpr (std::is_same_v<T, Interval>) {
                return section<Wide>(widened(l), widened(r));
            } else {
                if (common_end) {
                    points_.assume(in_doubles(x), f_->y(in_doubles(x)));
                } else {
                    add_assumed(x);
                }
                return close(r.sign);
            }
        }
        // Off the middle when a zero lies too near to it.
        for (const double share : {0.5, 0.40625, 0.625}) {
            const T from(l.x.upper(), l.x.upper()), to(r.x.lower(), r.x.lower());
            const T middle((from + T(share) * (to - from)).mid());
            if (!(from.upper() < middle.lower() && middle.upper() < to.lower())) break;
            const auto sign = difference(middle).sign();
            if (!sign || *sign == Sign::Zero) continue;
            count<T>();
            const Node<T> node{middle, *sign};
            section(l, node);
            section(node, r);
            return;
        }
        if constexpr (std::is_same_v<T, Interval>) {
            section<Wide>(widened(l), widened(r));
        } else {
            if (!common_end) {
                add_assumed(x);
            } else {
                points_.assume(in_doubles(x), f_->y(in_doubles(x)));
                // Equal at both ends and wherever it was looked at in between.
                result_.coincide = l.sign == Sign::Zero && r.sign == Sign::Zero;
            }
            close(r.sign);
        }
    }

    static Node<Wide> as_wide(const Node<Interval>& n) { return {Wide(n.x), n.sign}; }
    // Inner nodes are doubles; the ends of the range are known better than by their boxes of doubles.
    Node<Wide> widened(const Node<Interval>& n) {
        for (const Point p : {first_, last_}) {
            const Interval& x = points_[p].x;
            if (x.lower() == n.x.lower() && x.upper() == n.x.upper())
                return {points_.fine_box(p).first, n.sign};
        }
        return as_wide(n);
    }

    // Too narrow for the number type, or a gap below what is looked at.
    template <class T>
    bool is_negligible(const T& x) const {
        const Interval rough = in_doubles(x);
        const double scale = std::max(rough.magnitude(), f_->y(rough).magnitude());
        const double width = std::is_same_v<T, Interval> ? 0x1p-44 : assumed_width;
        if (x.upper() - x.lower() <= scale * width) return true;
        if (std::is_same_v<T, Interval>) return false;
        const T d = difference(x);
        return d.lower() >= -scale * width && d.upper() <= scale * width;
    }

    // Right of the last point found, up to the next node.
    void close(Sign sign) {
        if (sign != Sign::Zero && result_.signs.size() == result_.points.size())
            result_.signs.push_back(sign);
    }

    /// A point known to lie on both branches strictly between two places.
    template <class T>
    std::optional<Point> known_between(const T& x) {
        for (const BranchId on : {a_, b_}) {
            for (const Point q : points_.on(on)) {
                const Point p = points_.representative(q);
                const Interval& rough = points_[p].x;
                if (T(rough).upper() < x.lower() || T(rough).lower() > x.upper()) continue;
                if (!points_.is_known_on(p, a_) || !points_.is_known_on(p, b_)) continue;
                const auto px = points_.fine_box(p).first;
                if (px.lower() > Wide(x).lower() && px.upper() < Wide(x).upper()) return p;
            }
        }
        return std::nullopt;
    }

    template <class T>
    static T enclose_crossing(const MonotoneGraph& f, const MonotoneGraph& g, const T& x, Sign right) {
        const auto directed = [&](const T& t) { return right == Sign::Positive ? t : -t; };
        return enclose_zero(
            x, [&](const T& m) { return directed(f.y(m) - g.y(m)); },
            [&](const T& part) {
                const Direction<T> d = f.direction(part), e = g.direction(part);
                return directed(d.dy / d.dx - e.dy / e.dx);
            });
    }

    /// The one zero between two places with opposite signs, where the difference is monotone.
    template <class T>
    void add_crossing(const Node<T>& l, const Node<T>& r) {
        const T range(l.x.upper(), r.x.lower());
        std::optional<Point> p = known_between(range);
        if (!p) {
            const T tight = enclose_crossing<T>(*f_, *g_, range, r.sign);
            const Interval x = in_doubles(tight), y = in_doubles(clamped(f_->y(tight), g_->y(tight)));
            const auto refine = [f = f_, g = g_, start = Wide(range), right = r.sign] {
                const Wide fine = enclose_crossing<Wide>(*f, *g, start, right);
                return std::pair(fine, clamped(f->y(fine), g->y(fine)));
            };
            p = points_.add({x, y, refine, nullptr, {a_, b_}});
        }
        points_.note_on(*p, a_);
        points_.note_on(*p, b_);
        result_.points.push_back(*p);
    }

    /// A common point that is taken for granted somewhere in x: a tangency, or zeros too near to each other.
    void add_assumed(Wide x) {
        const bool goes_on = assumed_ && assumed_->upper() == x.lower();
        if (goes_on) {
            // Two neighbouring sections that are negligible hold one common point.
            x = hull(*assumed_, x);
            result_.signs.pop_back();
        }
        assumed_ = x;
        const std::pair<Wide, Wide> box{x, hull(f_->y(x), g_->y(x))};
        const Interval rough_x = x.enclosure(), rough_y = box.second.enclosure();
        if (!goes_on) points_.assume(rough_x, rough_y);
        if (const std::optional<Point> known = known_between(x)) {
            if (goes_on) result_.points.pop_back();
            points_.note_on(*known, a_);
            points_.note_on(*known, b_);
            result_.points.push_back(*known);
            return;
        }
        const CurvePoints::Data data{rough_x, rough_y, [box] { return box; }, nullptr, {a_, b_}};
        if (goes_on) {
            points_.replace(result_.points.back(), data);
        } else {
            result_.points.push_back(points_.add(data));
        }
    }

    CurveArcs& m_;
    CurvePoints& points_;
    BranchId a_, b_;
    std::shared_ptr<const MonotoneGraph> f_, g_;
    Point first_, last_;
    std::optional<Wide> assumed_;  // the section of the last common point, if that was assumed
    Meeting result_;
};

CurveArcs::Meeting CurveArcs::meet_vertical(BranchId vertical, BranchId b) {
    const Branch &line = branches_[vertical], &branch = branches_[b];
    if (curves_[branch.curve].circular()) {
        Meeting m;
        for (const Point p : crossings(line.curve, branch.curve)) {
            if (on_half(p, b)) m.points.push_back(p);
        }
        return m;
    }
    for (const Point q : std::vector(points_.on(b))) {
        if (points_.is_known_on(q, vertical)) return {false, {points_.representative(q)}, {}};
    }
    const Sign left = points_.compare_x(branch.left, line.anchor),
               right = points_.compare_x(branch.right, line.anchor);
    if (left == Sign::Positive || right == Sign::Negative) return {};
    if (left == Sign::Zero || right == Sign::Zero) {
        const Point p = left == Sign::Zero ? branch.left : branch.right;
        points_.note_on(p, vertical);
        return {false, {p}, {}};
    }
    const CurvePoints::Data& anchor = points_[line.anchor];
    const auto refine = [graph = branch.graph, at = anchor.exact] {
        const Wide x = coordinate_of<Wide>(at->x, at->denominator);
        return std::pair(x, graph->y(x));
    };
    return {false, {points_.add({anchor.x, branch.graph->y(anchor.x), refine, nullptr, {vertical, b}})}, {}};
}

CurveArcs::Meeting CurveArcs::meet(BranchId a, BranchId b) {
    // By value: points and branches may be added meanwhile.
    const Branch f = branches_[a], g = branches_[b];
    if (!f.graph) return g.graph ? meet_vertical(a, b) : Meeting();
    if (!g.graph) return meet_vertical(b, a);
    if (f.curve == g.curve && curves_[f.curve].kind != Curve::Kind::Bezier) {
        // A circle is simple: its halves share ends and nothing else.
        std::vector<Point> shared;
        for (const auto& [p, q] : {std::pair(f.left, g.left), std::pair(f.left, g.right),
                                   std::pair(f.right, g.left), std::pair(f.right, g.right)}) {
            if (p.valid() && points_.representative(p) == points_.representative(q)) shared.push_back(p);
        }
        std::sort(shared.begin(), shared.end(),
                  [&](Point p, Point q) { return compare_xy(p, q) == Sign::Negative; });
        return with_signs_between(a, b, shared);
    }
    if (curves_[f.curve].circular() && curves_[g.curve].circular()) {
        std::vector<Point> points = crossings(f.curve, g.curve);
        std::erase_if(points, [&](Point p) { return !on_half(p, a) || !on_half(p, b); });
        return with_signs_between(a, b, points);
    }
    return Isolation(*this, a, b).run();
}

const CurveArcs::Meeting& CurveArcs::meeting(BranchId a, BranchId b) {
    const auto key = std::minmax(a, b);
    if (const auto found = meetings_.find(key); found != meetings_.end()) return found->second;
    return meetings_.emplace(key, meet(key.first, key.second)).first->second;
}

Sign CurveArcs::compare_y_right_of(const Arc& a, const Arc& b, Point p) {
    if (is_vertical(a) || is_vertical(b)) return sign_of(int{is_vertical(a)} - int{is_vertical(b)});
    if (a.branch == b.branch) return Sign::Zero;
    const Meeting& m = meeting(a.branch, b.branch);
    if (m.coincide) return Sign::Zero;
    std::size_t passed = 0;
    while (passed < m.points.size() && compare_xy(m.points[passed], p) != Sign::Positive) ++passed;
    return a.branch < b.branch ? m.signs[passed] : -m.signs[passed];
}

void CurveArcs::intersect(const Arc& a, const Arc& b, ArcIntersections<Point, Arc>& out) {
    const auto overlap = [&] {
        const Point from = compare_xy(a.left, b.left) == Sign::Negative ? b.left : a.left;
        const Point to = compare_xy(a.right, b.right) == Sign::Negative ? a.right : b.right;
        const Sign order = compare_xy(from, to);
        if (order == Sign::Zero) out.points.push_back(from);
        if (order == Sign::Negative) out.overlaps.push_back({a.branch, from, to});
    };
    if (a.branch == b.branch) return overlap();
    if (points_[a.left].x.lower() > points_[b.right].x.upper() ||
        points_[b.left].x.lower() > points_[a.right].x.upper())
        return;
    const Meeting& m = meeting(a.branch, b.branch);
    if (m.coincide) return overlap();
    for (const Point p : m.points) {
        const auto within = [&](const Arc& arc) {
            return compare_xy(p, arc.left) != Sign::Negative && compare_xy(p, arc.right) != Sign::Positive;
        };
        if (within(a) && within(b)) out.points.push_back(p);
    }
}

}  // namespace vcell
