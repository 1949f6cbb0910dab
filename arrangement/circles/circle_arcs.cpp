#include "circle_arcs.hpp"
#include "curve_order.hpp"
#include "point_star.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace vcell {

namespace {

using Shape = CircleArcs::Arc::Shape;

// The parity of a permutation of three different forms.
Sign parity(FormId i, FormId j, FormId k) {
    return sign_of((j.value > i.value ? 1 : -1) * (k.value > j.value ? 1 : -1) *
                   (k.value > i.value ? 1 : -1));
}

Eigen::Vector2d place(const KernelPoint& p) { return {p.x, p.y}; }

}  // namespace

// --- Identity. -----------------------------------------------------------------------------------------

std::size_t CircleArcs::KeyHash::operator()(const Key& key) const {
    // Fibonacci hashing of each half [Knuth98, 6.4].
    constexpr std::uint64_t golden = 0x9e3779b97f4a7c15u;
    const auto word = [&](int i) {
        return (std::uint64_t{key.forms[i].value} << 32) | key.forms[i + 1].value;
    };
    const std::uint64_t h = (word(0) * golden ^ word(2)) * golden;
    return h ^ (h >> 32);
}

// With w(i, j, k) = grad(i - j) x grad(i - k), which changes sign under every transposition: if c = +-(s - x)
// and d = +-(s - y) share the form s, the turn from c to d is the product of the two signs and w(s, x, y).
CircleArcs::Canonical CircleArcs::canonical(FormPair c, FormPair d) {
    assert(!same_forms(c, d));
    for (const bool c_reversed : {false, true}) {
        for (const bool d_reversed : {false, true}) {
            const FormPair sx = c_reversed ? c.reversed() : c, sy = d_reversed ? d.reversed() : d;
            if (sx.f != sy.f) continue;
            Key key{{sx.f, sx.g, sy.g, FormId()}};
            std::sort(key.forms.begin(), key.forms.begin() + 3);
            return {key, parity(sx.f, sx.g, sy.g) * sign_of(c_reversed == d_reversed ? 1 : -1)};
        }
    }
    Sign sign = Sign::Positive;
    for (FormPair* pair : {&c, &d}) {
        if (pair->f < pair->g) continue;
        *pair = pair->reversed();
        sign = -sign;
    }
    if (d.f < c.f) {
        std::swap(c, d);
        sign = -sign;
    }
    return {{{c.f, c.g, d.f, d.g}}, sign};
}

const CircleArcs::Meeting& CircleArcs::meeting(const Key& key, const Eigen::Vector2d& near,
                                               std::optional<Incidence> asked) {
    const auto [found, is_new] = meetings_.try_emplace(key);
    Meeting& m = found->second;
    if (!is_new) return m;
    const bool triple = !key.forms[3].valid();
    const FormPair c{key.forms[0], key.forms[1]};
    const FormPair d = triple ? FormPair{key.forms[0], key.forms[2]} : FormPair{key.forms[2], key.forms[3]};
    switch (kernel_.intersection_sign(c, d, near)) {
        case Sign::Positive: {
            m.kind = Meeting::Kind::Crossing;
            // Two lines have one point: ask first for the turn that doubles expect.
            const auto gradient = [&](FormPair curve) {
                const auto f = kernel_.form(curve.f).jet(near.x(), near.y());
                const auto g = kernel_.form(curve.g).jet(near.x(), near.y());
                return Eigen::Vector2d(f.gx - g.gx, f.gy - g.gy);
            };
            const Eigen::Vector2d u = gradient(c), v = gradient(d);
            const bool expect_negative = u.x() * v.y() < u.y() * v.x();
            const bool lines =
                kernel_.curvature_sign(c) == Sign::Zero && kernel_.curvature_sign(d) == Sign::Zero;
            for (const bool negative : {expect_negative, !expect_negative}) {
                const auto p = kernel_.intersection(c, d, negative ? Sign::Negative : Sign::Positive, near);
                if (p) m.points[negative] = *p;
                if (p && lines) break;
            }
            break;
        }
        case Sign::Zero:
            m.kind = Meeting::Kind::Touching;
            m.points[0] = kernel_.touching_point(c, d);
            break;
        case Sign::Negative:
            // A point of one curve that misses the other tells them apart at little cost.
            if (asked && sign_at(asked->point, asked->curve) != Sign::Zero) break;
            if (kernel_.same_curve(c, d)) m.kind = Meeting::Kind::SameCurve;
            break;
    }
    return m;
}

std::optional<PointId> CircleArcs::crossing(FormPair c, FormPair d, Sign orientation,
                                            const Eigen::Vector2d& near) {
    if (same_forms(c, d)) return std::nullopt;
    const auto [key, sign] = canonical(c, d);
    const Meeting& m = meeting(key, near, std::nullopt);
    const auto wanted = orientation == Sign::Zero ? Meeting::Kind::Touching : Meeting::Kind::Crossing;
    if (m.kind != wanted) return std::nullopt;
    const PointId p = m.points[orientation * sign == Sign::Negative];
    return p.valid() ? std::optional(p) : std::nullopt;
}

std::array<PointId, 2> CircleArcs::x_extremes(FormPair c) {
    const auto [low, high] = std::minmax(c.f, c.g);
    const auto [found, is_new] = extremes_.try_emplace((std::uint64_t{low.value} << 32) | high.value);
    if (is_new) found->second = {kernel_.leftmost_point(c), kernel_.rightmost_point(c)};
    return found->second;
}

PointId CircleArcs::representative(PointId p) {
    for (auto i = static_cast<std::uint32_t>(equal_to_.size()); i <= p.value; ++i) equal_to_.push_back({i});
    while (equal_to_[p] != p) p = equal_to_[p] = equal_to_[equal_to_[p]];
    return p;
}

// Near each other, by the same forms and with the same turn: one point under two names.
bool CircleArcs::known_equal(PointId p, PointId q) const {
    const KernelPoint &a = kernel_.point(p), &b = kernel_.point(q);
    if (std::abs(a.x - b.x) > 2 * (a.error + b.error) || same_forms(a.first, a.second) ||
        same_forms(b.first, b.second)) {
        return false;
    }
    const auto first = canonical(a.first, a.second), second = canonical(b.first, b.second);
    return first.key == second.key && a.orientation * first.sign == b.orientation * second.sign;
}

// A point of the curves `first` and `second` lies on the third curve of their triple as well.
bool CircleArcs::known_on(PointId p, FormPair c) const {
    const KernelPoint& k = kernel_.point(p);
    if (k.first == k.second) return k.orientation != Sign::Zero && same_forms(k.first, c);
    if (same_forms(k.first, c) || same_forms(k.second, c)) return true;
    const auto& forms = canonical(k.first, k.second).key.forms;
    return !forms[3].valid() && std::count(forms.begin(), forms.end(), c.f) > 0 &&
           std::count(forms.begin(), forms.end(), c.g) > 0;
}

Sign CircleArcs::sign_at(PointId p, FormPair c) {
    return known_on(p, c) ? Sign::Zero : kernel_.sign_at(p, c.f, c.g);
}

Sign CircleArcs::turn_at(PointId p, FormPair c, FormPair d) {
    const KernelPoint& k = kernel_.point(p);
    if (!same_forms(k.first, k.second) && !same_forms(c, d)) {
        const auto known = canonical(k.first, k.second), asked = canonical(c, d);
        if (known.key == asked.key) return k.orientation * known.sign * asked.sign;
    }
    return kernel_.turn_at(p, c, d);
}

// --- Cutting. ------------------------------------------------------------------------------------------

CircleArcs::Arc CircleArcs::make_arc(FormPair rightward, PointId left, PointId right, Shape shape) const {
    return {rightward, left, right, shape, kernel_.arc_bounds(rightward, left, right).box};
}

void CircleArcs::cut_circle(FormPair c, std::vector<Arc>& out) {
    const auto [left, right] = x_extremes(c);
    const bool counter_clockwise = kernel_.curvature_sign(c) == Sign::Positive;
    out.push_back(make_arc(counter_clockwise ? c : c.reversed(), left, right, Shape::Lower));
    out.push_back(make_arc(counter_clockwise ? c.reversed() : c, left, right, Shape::Upper));
}

void CircleArcs::cut_arc(FormPair c, PointId p, PointId q, std::vector<Arc>& out) {
    assert(compare_xy(p, q) != Sign::Zero);
    const Sign curvature = kernel_.curvature_sign(c);
    if (curvature == Sign::Zero) {
        const Shape shape = kernel_.compare_x(p, q) == Sign::Zero ? Shape::Vertical : Shape::Line;
        const bool rightward = compare_xy(p, q) == Sign::Negative;
        out.push_back(rightward ? make_arc(c, p, q, shape) : make_arc(c.reversed(), q, p, shape));
        return;
    }
    const auto [left, right] = x_extremes(c);
    const Sign half = kernel_.side_of_center(p, c);
    const bool at_left = half == Sign::Zero && compare_xy(p, left) == Sign::Zero;
    // From p the lower half comes first: always rightward on a counter-clockwise circle, leftward on
    // another. At an extreme point the half that the direction leads into comes first.
    const bool counter_clockwise = curvature == Sign::Positive;
    bool lower = half == Sign::Zero ? at_left == counter_clockwise : half == Sign::Negative;
    PointId from = p;
    for (int piece = 0;; ++piece, lower = !lower) {
        const bool rightward = lower == counter_clockwise;
        const PointId extreme = rightward ? right : left;
        // A third piece runs on the half of the first, towards an extreme point that has been passed.
        const bool last = piece == 2 || !CurveOrder(kernel_, c).strictly_between(p, q, extreme);
        const PointId to = last ? q : extreme;
        const Shape shape = lower ? Shape::Lower : Shape::Upper;
        out.push_back(rightward ? make_arc(c, from, to, shape) : make_arc(c.reversed(), to, from, shape));
        if (last) return;
        from = to;
    }
}

CircleArcs::Arc CircleArcs::sub_arc(const Arc& a, PointId left, PointId right) const {
    const KernelPoint &l = kernel_.point(left), &r = kernel_.point(right);
    Arc part = a;
    part.left = left;
    part.right = right;
    part.box[0] = std::max(a.box[0], Interval::down(l.x - l.error));
    part.box[1] = std::min(a.box[1], Interval::up(r.x + r.error));
    return part;
}

std::pair<CircleArcs::Arc, CircleArcs::Arc> CircleArcs::split(const Arc& a, PointId p) const {
    return {sub_arc(a, a.left, p), sub_arc(a, p, a.right)};
}

// --- Predicates. ---------------------------------------------------------------------------------------

Sign CircleArcs::compare_xy(PointId p, PointId q) {
    p = representative(p);
    q = representative(q);
    if (p == q) return Sign::Zero;
    const Sign s = known_equal(p, q) ? Sign::Zero : kernel_.compare_xy(p, q);
    if (s == Sign::Zero) equal_to_[std::max(p, q)] = std::min(p, q);
    return s;
}

Sign CircleArcs::compare_y_at_x(PointId p, const Arc& a) {
    if (a.shape == Shape::Vertical) {
        if (compare_xy(p, a.left) == Sign::Negative) return Sign::Negative;
        return compare_xy(p, a.right) == Sign::Positive ? Sign::Positive : Sign::Zero;
    }
    const Sign above = -sign_at(p, a.curve);  // on the side that has f < g
    if (a.shape == Shape::Line) return above;
    // Above the lower and below the upper half is the inside. Outside, and within the circle's x-range, the
    // whole circle lies on one side of p; on the circle, p is on this half or beyond the other.
    const Sign inside = a.shape == Shape::Lower ? Sign::Positive : Sign::Negative;
    if (above == inside) return inside;
    const Sign side = kernel_.side_of_center(p, a.curve);
    if (above == Sign::Zero && side != inside) return Sign::Zero;
    return side;
}

Sign CircleArcs::compare_y_right_of(const Arc& a, const Arc& b, PointId p) {
    if (is_vertical(a) || is_vertical(b)) return sign_of(int{is_vertical(a)} - int{is_vertical(b)});
    const Sign by_half = a.shape == b.shape        ? Sign::Zero
                         : a.shape == Shape::Upper ? Sign::Positive
                                                   : Sign::Negative;
    if (same_forms(a.curve, b.curve)) return by_half;
    // Both directed to the right: b to a turns left if a is above.
    const Sign turn = turn_at(p, b.curve, a.curve);
    if (turn != Sign::Zero) return turn;
    // Opposite directions: from the leftmost point of two circles, one goes up and one goes down.
    if (by_half != Sign::Zero && !PointStar(kernel_, p).same_direction(a.curve, b.curve)) return by_half;
    // The one that bends further left is above.
    return PointStar(kernel_, p).sign_beside_touching(b.curve, a.curve);
}

bool CircleArcs::lies_on(const Arc& a, PointId p) {
    const PointId r = representative(p);
    if (r == representative(a.left) || r == representative(a.right)) return true;
    const KernelPoint& k = kernel_.point(p);
    if (k.x + k.error < a.box[0] || k.x - k.error > a.box[1] || k.y + k.error < a.box[2] ||
        k.y - k.error > a.box[3]) {
        return false;
    }
    if (a.shape == Shape::Lower && kernel_.side_of_center(p, a.curve) == Sign::Positive) return false;
    if (a.shape == Shape::Upper && kernel_.side_of_center(p, a.curve) == Sign::Negative) return false;
    return compare_xy(p, a.left) != Sign::Negative && compare_xy(p, a.right) != Sign::Positive;
}

void CircleArcs::intersect_same_curve(const Arc& a, const Arc& b, ArcIntersections<PointId, Arc>& out) {
    if (a.shape != b.shape) {
        // Two halves of a circle: they share its extreme points.
        if (compare_xy(a.left, b.left) == Sign::Zero) out.points.push_back(a.left);
        if (compare_xy(a.right, b.right) == Sign::Zero) out.points.push_back(a.right);
        return;
    }
    const PointId from = compare_xy(a.left, b.left) == Sign::Negative ? b.left : a.left;
    const PointId to = compare_xy(a.right, b.right) == Sign::Negative ? a.right : b.right;
    const Sign order = compare_xy(from, to);
    if (order == Sign::Zero) out.points.push_back(from);
    if (order == Sign::Negative) out.overlaps.push_back(sub_arc(a, from, to));
}

void CircleArcs::intersect(const Arc& a, const Arc& b, ArcIntersections<PointId, Arc>& out) {
    const double x0 = std::max(a.box[0], b.box[0]), x1 = std::min(a.box[1], b.box[1]);
    const double y0 = std::max(a.box[2], b.box[2]), y1 = std::min(a.box[3], b.box[3]);
    if (x0 > x1 || y0 > y1) return;
    if (same_forms(a.curve, b.curve)) return intersect_same_curve(a, b, out);

    const auto key = canonical(a.curve, b.curve).key;
    const Eigen::Vector2d middle(0.5 * x0 + 0.5 * x1, 0.5 * y0 + 0.5 * y1);
    const Eigen::Vector2d near = middle.allFinite() ? middle : place(kernel_.point(a.left));
    const Meeting& m = meeting(key, near, Incidence{a.left, b.curve});
    if (m.kind == Meeting::Kind::SameCurve) return intersect_same_curve(a, b, out);
    const std::size_t first = out.points.size();
    for (const PointId p : m.points) {
        if (p.valid() && lies_on(a, p) && lies_on(b, p)) out.points.push_back(p);
    }
    if (out.points.size() == first + 2 &&
        compare_xy(out.points[first], out.points[first + 1]) == Sign::Positive) {
        std::swap(out.points[first], out.points[first + 1]);
    }
}

}  // namespace vcell
