#include "mixed_arcs.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>

namespace vcell {

namespace {

template <class T>
bool excludes_zero(const T& t) {
    return t.lower() > 0 || t.upper() < 0;
}

/// Sign of p - q where the intervals do not overlap, or are one and the same point.
template <class T>
std::optional<Sign> compare_intervals(const T& p, const T& q) {
    if (p.lower() > q.upper()) return Sign::Positive;
    if (p.upper() < q.lower()) return Sign::Negative;
    if (p.lower() == p.upper() && q.lower() == p.lower() && q.upper() == p.lower()) return Sign::Zero;
    return std::nullopt;
}

template <class T>
T value_of(const OneRoot& v, const Exact& denominator) {
    return (enclosure_of<T>(v.a) + enclosure_of<T>(v.b) * sqrt(enclosure_of<T>(v.c))) /
           enclosure_of<T>(denominator);
}

Interval in_doubles(const Interval& i) { return i; }
Interval in_doubles(const Wide& i) { return i.enclosure(); }

Exact twice(const Exact& e) { return e.scaled(1); }

}  // namespace

// --- Curves. -------------------------------------------------------------------------------------------

MixedCurveId CurveArcs::add_circular(const CircularForm& given, std::optional<Label> label) {
    CircularForm f = given;
    if (f.k < 0) f = {.k = -f.k, .cx = f.cx, .cy = f.cy, .a = -f.a, .b = -f.b, .e = -f.e};
    const Exact k(f.k), cx(f.cx), cy(f.cy), a(f.a), b(f.b), e(f.e);
    const ExactForm form{k, a - twice(k * cx), b - twice(k * cy), k * (cx * cx + cy * cy) + e, Exact(1.0)};

    const auto coefficients = [](const ExactForm& g) { return std::array{&g.K, &g.A, &g.B, &g.C}; };
    const auto proportional = [&](const ExactForm& g) {
        const auto p = coefficients(form), q = coefficients(g);
        for (int i = 0; i < 4; ++i) {
            for (int j = i + 1; j < 4; ++j) {
                if (!(*p[i] * *q[j] == *p[j] * *q[i])) return false;
            }
        }
        return true;
    };
    for (const MixedCurveId c : curves_.ids()) {
        if (!curves_[c].circular() || !proportional(curves_[c].exact)) continue;
        if (label) curves_[c].labels.push_back(*label);
        return c;
    }

    const bool line = f.k == 0;
    const MixedCurveId c =
        curves_.push_back({line ? Curve::Kind::Line : Curve::Kind::Circle, {}, {}, f, form, {}});
    if (label) curves_[c].labels.push_back(*label);
    if (line) {
        assert(f.a != 0 || f.b != 0);
        const bool vertical = f.b == 0;
        const MixedBranchId branch =
            add_branch(c, vertical ? nullptr : std::make_shared<MonotoneGraph>(CircularGraph{f}), {}, {});
        if (vertical) {
            const bool positive = f.a > 0;
            branches_[branch].anchor = add_exact_point({{positive ? -e : e, {}, {}}, {}, positive ? a : -a});
            note_on(branches_[branch].anchor, branch);
        }
        return c;
    }
    const Exact discriminant = form.A * form.A + form.B * form.B - (form.K * form.C).scaled(2);
    assert(discriminant.sign() == Sign::Positive);
    std::array<Point, 2> extremes;
    for (const int i : {0, 1}) {
        extremes[i] = add_exact_point({{-form.A, Exact(i == 0 ? -1.0 : 1.0), discriminant},
                                       {-form.B, {}, discriminant},
                                       twice(form.K)});
    }
    for (const Sign half : {Sign::Negative, Sign::Positive})
        add_branch(c, std::make_shared<MonotoneGraph>(CircularGraph{f, half}), extremes[0], extremes[1]);
    return c;
}

MixedCurveId CurveArcs::add_bezier(std::vector<Eigen::Vector3d> points) {
    for (const MixedCurveId c : curves_.ids()) {
        if (curves_[c].kind != Curve::Kind::Bezier) continue;
        const auto& other = curves_[c].bezier->points();
        if (points == other || std::equal(points.rbegin(), points.rend(), other.begin(), other.end()))
            return c;
    }
    auto bezier = std::make_shared<const RationalBezier>(std::move(points));
    const MixedCurveId c = curves_.push_back({Curve::Kind::Bezier, {}, {}, {}, {}, bezier});
    const auto &first = bezier->points().front(), &last = bezier->points().back();
    BernsteinRoot from(0.0);
    Point from_point = point(first.x(), first.y());
    bool rightward = bezier->starts_rightward();
    for (std::size_t i = 0; i <= bezier->turns().size(); ++i, rightward = !rightward) {
        const bool at_end = i == bezier->turns().size();
        const BernsteinRoot to = at_end ? BernsteinRoot(1.0) : bezier->turns()[i];
        Point to_point;
        if (at_end) {
            to_point = point(last.x(), last.y());
        } else {
            const auto [x, y] = bezier->at(to.enclosure<Interval>());
            to_point =
                add_point({x, y, [bezier, to] { return bezier->at(to.enclosure<Wide>()); }, nullptr, {}, {}});
        }
        const auto graph = std::make_shared<MonotoneGraph>(BezierGraph{bezier, from, to, rightward});
        add_branch(c, graph, rightward ? from_point : to_point, rightward ? to_point : from_point);
        from = to;
        from_point = to_point;
    }
    return c;
}

MixedCurveId CurveArcs::add_traced(const TracedCurve& curve, std::optional<Label> label) {
    const TracedPieces cut = cut_traced_curve(curve);
    for (const Eigen::Vector2d& p : cut.assumed) assume(p.x(), p.y());
    const MixedCurveId c = curves_.push_back({Curve::Kind::Traced, {}, {}, {}, {}, nullptr});
    if (label) curves_[c].labels.push_back(*label);
    std::map<std::shared_ptr<const TracedPlace>, Point> points;
    const auto point_at = [&](const std::shared_ptr<const TracedPlace>& place) {
        const auto [found, is_new] = points.try_emplace(place);
        if (is_new) {
            const auto [x, y] = place->enclosure<Interval>();
            found->second = add_point({x, y, [place] { return place->enclosure<Wide>(); }, nullptr, {}, {}});
        }
        return found->second;
    };
    for (const TracedPiece& piece : cut.pieces) {
        const Point left = point_at(piece.left), right = point_at(piece.right);
        add_branch(c, std::make_shared<const MonotoneGraph>(piece.graph), left, right);
    }
    return c;
}

MixedBranchId CurveArcs::add_branch(MixedCurveId c, std::shared_ptr<const MonotoneGraph> graph, Point left,
                                    Point right) {
    const MixedBranchId b = branches_.push_back({c, std::move(graph), left, right, {}});
    points_on_.push_back({});
    curves_[c].branches.push_back(b);
    for (const Point p : {left, right}) {
        if (p.valid()) note_on(p, b);
    }
    return b;
}

void CurveArcs::cut(MixedCurveId c, std::vector<Arc>& out) const {
    assert(curves_[c].kind != Curve::Kind::Line);
    for (const MixedBranchId b : curves_[c].branches)
        out.push_back({b, branches_[b].left, branches_[b].right});
}

CurveArcs::Arc CurveArcs::segment(MixedCurveId line, Point p, Point q) {
    assert(curves_[line].kind == Curve::Kind::Line);
    const MixedBranchId b = curves_[line].branches.front();
    for (const Point end : {p, q}) note_on(end, b);
    return sub_arc({b, {}, {}}, p, q);
}

CurveArcs::Arc CurveArcs::sub_arc(const Arc& a, Point p, Point q) {
    const Sign order = compare_xy(p, q);
    assert(order != Sign::Zero);
    return order == Sign::Negative ? Arc{a.branch, p, q} : Arc{a.branch, q, p};
}

// --- Points and their identity. ------------------------------------------------------------------------

CurveArcs::Point CurveArcs::add_point(PointData data) {
    const Point p = points_.push_back(data);
    equal_to_.push_back(p);
    equal_x_.push_back(p);
    for (const MixedBranchId b : data.on) points_on_[b].push_back(p);
    return p;
}

CurveArcs::Point CurveArcs::add_exact_point(ExactPoint exact) {
    const auto shared = std::make_shared<const ExactPoint>(std::move(exact));
    return add_point({enclosure(shared->x, shared->denominator),
                      enclosure(shared->y, shared->denominator),
                      [shared] {
                          return std::pair(value_of<Wide>(shared->x, shared->denominator),
                                           value_of<Wide>(shared->y, shared->denominator));
                      },
                      shared,
                      {},
                      {}});
}

CurveArcs::Point CurveArcs::point(double x, double y) {
    const auto [found, is_new] = given_.try_emplace({x, y});
    if (is_new) {
        found->second = add_exact_point({{Exact(x), {}, {}}, {Exact(y), {}, {}}, Exact(1.0)});
        points_[found->second].x = x;
        points_[found->second].y = y;
    }
    return found->second;
}

std::pair<Wide, Wide> CurveArcs::fine_box(Point p) {
    PointData& data = points_[p];
    if (!data.fine) data.fine = data.refine();
    return *data.fine;
}

CurveArcs::Point CurveArcs::representative(Classes& classes, Point p) {
    while (classes[p] != p) p = classes[p] = classes[classes[p]];
    return p;
}

void CurveArcs::unite(Point p, Point q) {
    p = representative(p);
    q = representative(q);
    if (p == q) return;
    // The exact one stands for both.
    if (!points_[p].exact && points_[q].exact) std::swap(p, q);
    equal_to_[q] = p;
    equal_x_[representative(equal_x_, q)] = representative(equal_x_, p);
    for (const MixedBranchId b : std::vector(points_[q].on)) note_on(p, b);
}

void CurveArcs::note_on(Point p, MixedBranchId b) {
    p = representative(p);
    auto& on = points_[p].on;
    if (std::find(on.begin(), on.end(), b) != on.end()) return;
    on.push_back(b);
    points_on_[b].push_back(p);
}

void CurveArcs::assume(const Interval& x, const Interval& y) {
    ++decisions_.assumed;
    assumed_at_.push_back({x.mid(), y.mid()});
}

// A point on {i = j} and {j = k} lies on {i = k}: the pair of b's curve must be joined by the pairs of the
// point's curves. Which part of {i = k} it lies on, its place tells.
bool CurveArcs::known_on(Point p, MixedBranchId b) const {
    const PointData& data = points_[representative(p)];
    if (std::find(data.on.begin(), data.on.end(), b) != data.on.end()) return true;
    const Branch& branch = branches_[b];
    const auto joined = [&](const Label& wanted) {
        std::vector<std::uint32_t> reached{wanted.f};
        for (std::size_t i = 0; i < reached.size(); ++i) {
            const auto reach = [&](std::uint32_t from, std::uint32_t to) {
                if (from == reached[i] && std::find(reached.begin(), reached.end(), to) == reached.end())
                    reached.push_back(to);
            };
            for (const MixedBranchId on : data.on) {
                for (const Label& l : curves_[branches_[on].curve].labels) {
                    reach(l.f, l.g);
                    reach(l.g, l.f);
                }
            }
        }
        return std::find(reached.begin(), reached.end(), wanted.g) != reached.end();
    };
    const auto& labels = curves_[branch.curve].labels;
    if (std::none_of(labels.begin(), labels.end(), joined)) return false;
    if (!branch.graph) return true;
    if (const auto* traced = std::get_if<TracedGraph>(&branch.graph->shape()))
        return traced->holds_alone(data.x, data.y);
    if (const auto* circular = std::get_if<CircularGraph>(&branch.graph->shape())) {
        if (circular->half == Sign::Zero) return true;
        const CircularForm& f = circular->form;
        const Interval g_y = Interval(2.0) * Interval(f.k) * (data.y - Interval(f.cy)) + Interval(f.b);
        return g_y.sign() == circular->half;
    }
    return false;
}

CurveArcs::Comparison CurveArcs::compare_coordinate(Point p, Point q, int axis) {
    p = representative(p);
    q = representative(q);
    if (p == q) return {Sign::Zero};
    const PointData &a = points_[p], &b = points_[q];
    const auto on_vertical_of_a = [&](MixedBranchId on) {
        return !branches_[on].graph && std::find(a.on.begin(), a.on.end(), on) != a.on.end();
    };
    if (axis == 0 && (representative(equal_x_, p) == representative(equal_x_, q) ||
                      std::any_of(b.on.begin(), b.on.end(), on_vertical_of_a)))
        return {Sign::Zero};
    if (const auto s = axis == 0 ? compare_intervals(a.x, b.x) : compare_intervals(a.y, b.y)) {
        ++decisions_.by_interval;
        return {*s};
    }
    if (a.exact && b.exact) {
        ++decisions_.by_exact;
        const OneRoot &u = axis == 0 ? a.exact->x : a.exact->y, &v = axis == 0 ? b.exact->x : b.exact->y;
        return {compare(u, a.exact->denominator, v, b.exact->denominator)};
    }
    const auto [ax, ay] = fine_box(p);
    const auto [bx, by] = fine_box(q);
    if (const auto s = axis == 0 ? compare_intervals(ax, bx) : compare_intervals(ay, by)) {
        ++decisions_.by_multiprecision;
        return {*s};
    }
    return {Sign::Zero, true};
}

Sign CurveArcs::compare_x(Point p, Point q) {
    const Comparison c = compare_coordinate(p, q, 0);
    if (c.assumed) assume(points_[p].x, points_[p].y);
    if (c.sign == Sign::Zero) equal_x_[representative(equal_x_, p)] = representative(equal_x_, q);
    return c.sign;
}

Sign CurveArcs::compare_xy(Point p, Point q) {
    if (representative(p) == representative(q)) return Sign::Zero;
    const Comparison by_x = compare_coordinate(p, q, 0);
    if (by_x.sign != Sign::Zero) return by_x.sign;
    equal_x_[representative(equal_x_, p)] = representative(equal_x_, q);
    const Comparison by_y = compare_coordinate(p, q, 1);
    if (by_x.assumed || by_y.assumed) assume(points_[p].x, points_[p].y);
    if (by_y.sign == Sign::Zero) unite(p, q);
    return by_y.sign;
}

// --- Points and branches. ------------------------------------------------------------------------------

// The sign of K (x^2 + y^2) + A x + B y + C tells the side of a line, and inside from outside of a circle.
Sign CurveArcs::exact_side_of(const ExactPoint& p, MixedBranchId b) const {
    const Branch& branch = branches_[b];
    const ExactForm& f = curves_[branch.curve].exact;
    const Exact& d = p.denominator;
    const OneRoot value = f.K * (p.x * p.x + p.y * p.y) + (d * f.A) * p.x + (d * f.B) * p.y + d * d * f.C;
    const Sign s = sign(value);
    const Sign half = std::get<CircularGraph>(branch.graph->shape()).half;
    if (half == Sign::Zero) return s * f.B.sign();
    if (s == Sign::Negative) return -half;
    // On the circle or, within its x-range, above or below all of it.
    const Sign level = sign(twice(f.K) * p.y + d * f.B);
    if (s == Sign::Zero && level != -half) return Sign::Zero;
    return level;
}

// Of a point on the circle: does it lie on this half?
bool CurveArcs::on_half(Point p, MixedBranchId b) const {
    const Branch& branch = branches_[b];
    if (!branch.graph) return true;
    const Sign half = std::get<CircularGraph>(branch.graph->shape()).half;
    if (half == Sign::Zero) return true;
    const ExactForm& f = curves_[branch.curve].exact;
    const ExactPoint& e = *points_[p].exact;
    return sign(twice(f.K) * e.y + e.denominator * f.B) != -half;
}

Sign CurveArcs::side_of(Point p, MixedBranchId b) {
    p = representative(p);
    if (known_on(p, b)) return Sign::Zero;
    const auto graph = branches_[b].graph;
    const PointData& data = points_[p];
    if (const auto* traced = std::get_if<TracedGraph>(&graph->shape())) {
        if (const auto s = compare_intervals(data.y, traced->rough_y(data.x)); s && *s != Sign::Zero) {
            ++decisions_.by_double;
            return *s;
        }
    }
    if (const auto s = compare_intervals(data.y, graph->y(data.x))) {
        ++decisions_.by_interval;
        if (*s == Sign::Zero) note_on(p, b);
        return *s;
    }
    if (data.exact && curves_[branches_[b].curve].circular()) {
        ++decisions_.by_exact;
        const Sign s = exact_side_of(*data.exact, b);
        if (s == Sign::Zero) note_on(p, b);
        return s;
    }
    const auto [x, y] = fine_box(p);
    if (const auto s = compare_intervals(y, graph->y(x))) {
        ++decisions_.by_multiprecision;
        if (*s == Sign::Zero) note_on(p, b);
        return *s;
    }
    assume(data.x, data.y);
    note_on(p, b);
    return Sign::Zero;
}

Sign CurveArcs::compare_y_at_x(Point p, const Arc& a) {
    if (is_vertical(a)) {
        if (compare_xy(p, a.left) == Sign::Negative) return Sign::Negative;
        return compare_xy(p, a.right) == Sign::Positive ? Sign::Positive : Sign::Zero;
    }
    return side_of(p, a.branch);
}

// --- Meetings of branches. -----------------------------------------------------------------------------

// Two circles meet on their radical line K2 f1 - K1 f2, a line a x + b y + c. With n = a^2 + b^2 its points
// are
// (-a c, -b c) / n + s (-b, a), and those on K (x^2 + y^2) + A x + B y + C satisfy
//     K n s^2 + m s + q / n = 0,   m = B a - A b,   q = K c^2 - c (A a + B b) + C n,
// hence s = (-m -+ sqrt(m^2 - 4 K q)) / (2 K n).
std::vector<CurveArcs::Point> CurveArcs::exact_points(const Curve& c, const Curve& d) {
    const ExactForm &f = c.exact, &g = d.exact;
    const bool lines = c.kind == Curve::Kind::Line && d.kind == Curve::Kind::Line;
    const auto make = [&](OneRoot x, OneRoot y, Exact denominator) {
        const Exact s(denominator.sign() == Sign::Positive ? 1.0 : -1.0);
        const Point p = add_exact_point({s * x, s * y, s * denominator});
        for (const Curve* curve : {&c, &d}) {
            for (const MixedBranchId b : curve->branches) {
                if (on_half(p, b)) note_on(p, b);
            }
        }
        return p;
    };
    if (lines) {
        const Exact determinant = f.A * g.B - g.A * f.B;
        if (determinant.sign() == Sign::Zero) return {};
        return {make({f.B * g.C - g.B * f.C, {}, {}}, {f.C * g.A - g.C * f.A, {}, {}}, determinant)};
    }
    const ExactForm& circle = c.kind == Curve::Kind::Circle ? f : g;
    const Exact a = g.K * f.A - f.K * g.A, b = g.K * f.B - f.K * g.B, e = g.K * f.C - f.K * g.C;
    const Exact n = a * a + b * b;
    if (n.sign() == Sign::Zero) return {};
    const auto& [K, A, B, C, W] = circle;
    const Exact m = B * a - A * b, q = K * e * e - e * (A * a + B * b) + C * n;
    const Exact discriminant = m * m - (K * q).scaled(2);
    const Exact x0 = b * m - twice(K * a * e), y0 = -(a * m) - twice(K * b * e), denominator = twice(K * n);
    if (discriminant.sign() == Sign::Negative) return {};
    if (discriminant.sign() == Sign::Zero) return {make({x0, {}, {}}, {y0, {}, {}}, denominator)};
    return {make({x0, -b, discriminant}, {y0, a, discriminant}, denominator),
            make({x0, b, discriminant}, {y0, -a, discriminant}, denominator)};
}

std::vector<CurveArcs::Point> CurveArcs::crossings(MixedCurveId c, MixedCurveId d) {
    assert(c != d && curves_[c].circular() && curves_[d].circular());
    const auto [found, is_new] = exact_points_.try_emplace(std::minmax(c, d));
    if (is_new) {
        found->second = exact_points(curves_[c], curves_[d]);
        std::sort(found->second.begin(), found->second.end(),
                  [&](Point p, Point q) { return compare_xy(p, q) == Sign::Negative; });
    }
    return found->second;
}

std::optional<CurveArcs::Point> CurveArcs::later_left(MixedBranchId a, MixedBranchId b) {
    const Point p = branches_[a].left, q = branches_[b].left;
    if (!p.valid() || !q.valid())
        return p.valid() ? std::optional(p) : q.valid() ? std::optional(q) : std::nullopt;
    return compare_x(p, q) == Sign::Negative ? q : p;
}

std::optional<CurveArcs::Point> CurveArcs::earlier_right(MixedBranchId a, MixedBranchId b) {
    const Point p = branches_[a].right, q = branches_[b].right;
    if (!p.valid() || !q.valid())
        return p.valid() ? std::optional(p) : q.valid() ? std::optional(q) : std::nullopt;
    return compare_x(p, q) == Sign::Positive ? q : p;
}

Sign CurveArcs::sign_between(MixedBranchId a, MixedBranchId b, std::optional<Point> l,
                             std::optional<Point> r) {
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
        ++decisions_.by_interval;
        return *s;
    }
    const auto fine = [&](std::optional<Point> p) {
        return p ? std::optional(fine_box(*p).first) : std::nullopt;
    };
    const auto s = sample(fine(l), fine(r));
    if (s && *s != Sign::Zero) {
        ++decisions_.by_multiprecision;
        return *s;
    }
    const Point at = l ? *l : *r;
    assume(points_[at].x, points_[at].y);
    return Sign::Zero;
}

CurveArcs::Meeting CurveArcs::with_signs_between(MixedBranchId a, MixedBranchId b,
                                                 std::vector<Point> points) {
    const auto first = later_left(a, b), last = earlier_right(a, b);
    Meeting m{false, std::move(points), {}};
    m.signs.assign(m.points.size() + 1, Sign::Zero);
    if (first && last && compare_x(*first, *last) != Sign::Negative) return m;
    for (std::size_t i = 0; i <= m.points.size(); ++i) {
        const auto l = i == 0 ? first : m.points[i - 1];
        const auto r = i == m.points.size() ? last : m.points[i];
        if (l && r && compare_x(*l, *r) != Sign::Negative) continue;
        m.signs[i] = sign_between(a, b, l, r);
    }
    return m;
}

/// Finds the common points of two branches that are no vertical lines.
class CurveArcs::Isolation {
public:
    Isolation(CurveArcs& arcs, MixedBranchId a, MixedBranchId b)
        : m_(arcs), a_(a), b_(b), f_(arcs.branches_[a].graph), g_(arcs.branches_[b].graph) {}

    Meeting run() {
        // One of the branches is bounded: two lines meet exactly.
        const Point first = m_.later_left(a_, b_).value(), last = m_.earlier_right(a_, b_).value();
        const Sign order = m_.compare_x(first, last);
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
        section<Interval>({m_.points_[first].x, left}, {m_.points_[last].x, right});
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

    Sign difference_at(Point p) { return m_.known_on(p, a_) ? m_.side_of(p, b_) : -m_.side_of(p, a_); }

    template <class T>
    T difference(const T& x) const {
        return f_->y(x) - g_->y(x);
    }
    template <class T>
    void count() {
        ++(std::is_same_v<T, Interval> ? m_.decisions_.by_interval : m_.decisions_.by_multiprecision);
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
            if (std::is_same_v<T, Interval> && bands_apart(in_doubles(x))) return close(r.sign);
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
                    m_.assume(in_doubles(x), f_->y(in_doubles(x)));
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
                m_.assume(in_doubles(x), f_->y(in_doubles(x)));
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
            const Interval& x = m_.points_[p].x;
            if (x.lower() == n.x.lower() && x.upper() == n.x.upper()) return {m_.fine_box(p).first, n.sign};
        }
        return as_wide(n);
    }

    bool bands_apart(const Interval& x) {
        const auto* f = std::get_if<TracedGraph>(&f_->shape());
        const auto* g = std::get_if<TracedGraph>(&g_->shape());
        if (!f && !g) return false;
        const Interval y = (f ? f->rough_y(x) : f_->y(x)) - (g ? g->rough_y(x) : g_->y(x));
        if (!excludes_zero(y)) return false;
        ++m_.decisions_.by_double;
        return true;
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
        for (const MixedBranchId on : {a_, b_}) {
            for (const Point q : m_.points_on_[on]) {
                const Point p = m_.representative(q);
                const Interval& rough = m_.points_[p].x;
                if (T(rough).upper() < x.lower() || T(rough).lower() > x.upper()) continue;
                if (!m_.known_on(p, a_) || !m_.known_on(p, b_)) continue;
                const auto px = m_.fine_box(p).first;
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
            p = m_.add_point({x, y, refine, nullptr, {a_, b_}, {}});
        }
        m_.note_on(*p, a_);
        m_.note_on(*p, b_);
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
        if (!goes_on) m_.assume(rough_x, rough_y);
        if (const std::optional<Point> known = known_between(x)) {
            if (goes_on) result_.points.pop_back();
            m_.note_on(*known, a_);
            m_.note_on(*known, b_);
            result_.points.push_back(*known);
            return;
        }
        const PointData data{rough_x, rough_y, [box] { return box; }, nullptr, {a_, b_}, {}};
        if (goes_on) {
            m_.points_[result_.points.back()] = data;
        } else {
            result_.points.push_back(m_.add_point(data));
        }
    }

    CurveArcs& m_;
    MixedBranchId a_, b_;
    std::shared_ptr<const MonotoneGraph> f_, g_;
    Point first_, last_;
    std::optional<Wide> assumed_;  // the section of the last common point, if that was assumed
    Meeting result_;
};

CurveArcs::Meeting CurveArcs::meet_vertical(MixedBranchId vertical, MixedBranchId b) {
    const Branch &line = branches_[vertical], &branch = branches_[b];
    if (curves_[branch.curve].circular()) {
        Meeting m;
        for (const Point p : crossings(line.curve, branch.curve)) {
            if (on_half(p, b)) m.points.push_back(p);
        }
        return m;
    }
    for (const Point q : std::vector(points_on_[b])) {
        if (known_on(q, vertical)) return {false, {representative(q)}, {}};
    }
    const Sign left = compare_x(branch.left, line.anchor), right = compare_x(branch.right, line.anchor);
    if (left == Sign::Positive || right == Sign::Negative) return {};
    if (left == Sign::Zero || right == Sign::Zero) {
        const Point p = left == Sign::Zero ? branch.left : branch.right;
        note_on(p, vertical);
        return {false, {p}, {}};
    }
    const PointData& anchor = points_[line.anchor];
    const auto refine = [graph = branch.graph, at = anchor.exact] {
        const Wide x = value_of<Wide>(at->x, at->denominator);
        return std::pair(x, graph->y(x));
    };
    return {
        false, {add_point({anchor.x, branch.graph->y(anchor.x), refine, nullptr, {vertical, b}, {}})}, {}};
}

CurveArcs::Meeting CurveArcs::meet(MixedBranchId a, MixedBranchId b) {
    // By value: points and branches may be added meanwhile.
    const Branch f = branches_[a], g = branches_[b];
    if (!f.graph) return g.graph ? meet_vertical(a, b) : Meeting();
    if (!g.graph) return meet_vertical(b, a);
    if (f.curve == g.curve && curves_[f.curve].kind != Curve::Kind::Bezier) {
        // Circles and traced curves are simple: their branches share ends and nothing else.
        std::vector<Point> shared;
        for (const auto& [p, q] : {std::pair(f.left, g.left), std::pair(f.left, g.right),
                                   std::pair(f.right, g.left), std::pair(f.right, g.right)}) {
            if (p.valid() && representative(p) == representative(q)) shared.push_back(p);
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

const CurveArcs::Meeting& CurveArcs::meeting(MixedBranchId a, MixedBranchId b) {
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
