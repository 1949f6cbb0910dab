#include "curve_arcs.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>

#include "../../core/curves/restricted_curve.hpp"

namespace vcell {

namespace {

/// Sign of p - q where the intervals do not overlap, or are one and the same point.
template <class T>
std::optional<Sign> compare_intervals(const T& p, const T& q) {
    if (p.lower() > q.upper()) return Sign::Positive;
    if (p.upper() < q.lower()) return Sign::Negative;
    if (p.lower() == p.upper() && q.lower() == p.lower() && q.upper() == p.lower()) return Sign::Zero;
    return std::nullopt;
}

Exact twice(const Exact& e) { return e.scaled(1); }

}  // namespace

// --- Curves. -------------------------------------------------------------------------------------------

CurveId CurveArcs::add_circular(const CircularForm& given) {
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
    for (const CurveId c : curves_.ids()) {
        if (!curves_[c].circular() || !proportional(curves_[c].exact)) continue;
        return c;
    }

    const bool line = f.k == 0;
    const CurveId c = curves_.push_back({line ? Curve::Kind::Line : Curve::Kind::Circle, {}, f, form, {}});
    if (line) {
        assert(f.a != 0 || f.b != 0);
        const bool vertical = f.b == 0;
        const BranchId branch =
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

CurveId CurveArcs::add_bezier(std::vector<Eigen::Vector3d> points) {
    for (const CurveId c : curves_.ids()) {
        if (curves_[c].kind != Curve::Kind::Bezier) continue;
        const auto& other = curves_[c].bezier->points();
        if (points == other || std::equal(points.rbegin(), points.rend(), other.begin(), other.end()))
            return c;
    }
    auto bezier = std::make_shared<const RationalBezier>(std::move(points));
    const CurveId c = curves_.push_back({Curve::Kind::Bezier, {}, {}, {}, bezier});
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

std::vector<CurveId> CurveArcs::add_spline(RationalCurve2 curve) {
    const int degree = curve.degree;
    const Knots knots = curve.knots;
    for (const double t : knots)
        while (std::count(curve.knots.begin(), curve.knots.end(), t) < degree) curve = with_knot(curve, t);
    std::vector<CurveId> spans;
    for (std::size_t i = 0; i + degree < curve.points.size(); i += degree)
        spans.push_back(add_bezier({curve.points.begin() + i, curve.points.begin() + i + degree + 1}));
    return spans;
}

BranchId CurveArcs::add_branch(CurveId c, std::shared_ptr<const MonotoneGraph> graph, Point left,
                               Point right) {
    const BranchId b = branches_.push_back({c, std::move(graph), left, right, {}});
    points_on_.push_back({});
    curves_[c].branches.push_back(b);
    for (const Point p : {left, right}) {
        if (p.valid()) note_on(p, b);
    }
    return b;
}

void CurveArcs::cut(CurveId c, std::vector<Arc>& out) const {
    assert(curves_[c].kind != Curve::Kind::Line);
    for (const BranchId b : curves_[c].branches) out.push_back({b, branches_[b].left, branches_[b].right});
}

CurveArcs::Arc CurveArcs::segment(CurveId line, Point p, Point q) {
    assert(curves_[line].kind == Curve::Kind::Line);
    const BranchId b = curves_[line].branches.front();
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
    equal_to_.add();
    equal_x_.add();
    for (const BranchId b : data.on) points_on_[b].push_back(p);
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

void CurveArcs::unite(Point p, Point q) {
    p = representative(p);
    q = representative(q);
    if (p == q) return;
    // The exact one stands for both.
    if (!points_[p].exact && points_[q].exact) std::swap(p, q);
    equal_to_.merge(q.value, p.value);
    equal_x_.merge(q.value, p.value);
    for (const BranchId b : std::vector(points_[q].on)) note_on(p, b);
}

void CurveArcs::note_on(Point p, BranchId b) {
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

bool CurveArcs::known_on(Point p, BranchId b) const {
    const std::vector<BranchId>& on = points_[representative(p)].on;
    return std::find(on.begin(), on.end(), b) != on.end();
}

CurveArcs::Comparison CurveArcs::compare_coordinate(Point p, Point q, int axis) {
    p = representative(p);
    q = representative(q);
    if (p == q) return {Sign::Zero};
    const PointData &a = points_[p], &b = points_[q];
    const auto on_vertical_of_a = [&](BranchId on) {
        return !branches_[on].graph && std::find(a.on.begin(), a.on.end(), on) != a.on.end();
    };
    if (axis == 0 && (equal_x_.find(p.value) == equal_x_.find(q.value) ||
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
    if (c.sign == Sign::Zero) equal_x_.merge(p.value, q.value);
    return c.sign;
}

Sign CurveArcs::compare_xy(Point p, Point q) {
    if (representative(p) == representative(q)) return Sign::Zero;
    const Comparison by_x = compare_coordinate(p, q, 0);
    if (by_x.sign != Sign::Zero) return by_x.sign;
    equal_x_.merge(p.value, q.value);
    const Comparison by_y = compare_coordinate(p, q, 1);
    if (by_x.assumed || by_y.assumed) assume(points_[p].x, points_[p].y);
    if (by_y.sign == Sign::Zero) unite(p, q);
    return by_y.sign;
}

// --- Points and branches. ------------------------------------------------------------------------------

// The sign of K (x^2 + y^2) + A x + B y + C tells the side of a line, and inside from outside of a circle.
Sign CurveArcs::exact_side_of(const ExactPoint& p, BranchId b) const {
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

// Does a point of the circle lie on this half? The two halves are graphs of their own.
bool CurveArcs::on_half(Point p, BranchId b) const {
    const Branch& branch = branches_[b];
    if (!branch.graph) return true;
    const Sign half = std::get<CircularGraph>(branch.graph->shape()).half;
    if (half == Sign::Zero) return true;
    const ExactForm& f = curves_[branch.curve].exact;
    const ExactPoint& e = *points_[p].exact;
    return sign(twice(f.K) * e.y + e.denominator * f.B) != -half;
}

Sign CurveArcs::side_of(Point p, BranchId b) {
    p = representative(p);
    if (known_on(p, b)) return Sign::Zero;
    const auto graph = branches_[b].graph;
    const PointData& data = points_[p];
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

// --- Common points of lines and circles. ----------------------------------------------------------------

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
            for (const BranchId b : curve->branches) {
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

std::vector<CurveArcs::Point> CurveArcs::crossings(CurveId c, CurveId d) {
    assert(c != d && curves_[c].circular() && curves_[d].circular());
    const auto [found, is_new] = exact_points_.try_emplace(std::minmax(c, d));
    if (is_new) {
        found->second = exact_points(curves_[c], curves_[d]);
        std::sort(found->second.begin(), found->second.end(),
                  [&](Point p, Point q) { return compare_xy(p, q) == Sign::Negative; });
    }
    return found->second;
}

}  // namespace vcell
