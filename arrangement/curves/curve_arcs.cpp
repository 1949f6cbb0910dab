#include "curve_arcs.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>

#include "../../core/curves/restricted_curve.hpp"

namespace vcell {

namespace {

/// Names half a circle; a line has the half Zero.
Sign half_of(const MonotoneGraph& graph) { return std::get<CircularGraph>(graph.shape()).half; }

}  // namespace

// --- Curves. -------------------------------------------------------------------------------------------

CurveId CurveArcs::add_circular(const CircularForm& given) {
    CircularForm f = given;
    if (f.k < 0) f = {.k = -f.k, .cx = f.cx, .cy = f.cy, .a = -f.a, .b = -f.b, .e = -f.e};
    const ExactForm form = exact_form(f);
    for (const CurveId c : curves_.ids())
        if (curves_[c].circular() && are_same_curve(form, curves_[c].exact)) return c;

    const bool line = f.k == 0;
    const CurveId c = curves_.push_back({line ? Curve::Kind::Line : Curve::Kind::Circle, {}, f, form, {}});
    if (line) {
        assert(f.a != 0 || f.b != 0);
        const bool vertical = f.b == 0;
        const BranchId branch =
            add_branch(c, vertical ? nullptr : std::make_shared<MonotoneGraph>(CircularGraph{f}), {}, {});
        if (vertical) {
            branches_[branch].anchor = points_.add(foot_of_vertical(form));
            points_.note_on(branches_[branch].anchor, branch);
        }
        return c;
    }
    const Point left = points_.add(x_extreme(form, Sign::Negative)),
                right = points_.add(x_extreme(form, Sign::Positive));
    for (const Sign half : {Sign::Negative, Sign::Positive})
        add_branch(c, std::make_shared<MonotoneGraph>(CircularGraph{f, half}), left, right);
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
            to_point = points_.add({x, y, [bezier, to] { return bezier->at(to.enclosure<Wide>()); }});
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
    points_.add_branch(!branches_[b].graph);
    curves_[c].branches.push_back(b);
    for (const Point p : {left, right}) {
        if (p.valid()) points_.note_on(p, b);
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
    for (const Point end : {p, q}) points_.note_on(end, b);
    return sub_arc({b, {}, {}}, p, q);
}

CurveArcs::Arc CurveArcs::sub_arc(const Arc& a, Point p, Point q) {
    const Sign order = compare_xy(p, q);
    assert(order != Sign::Zero);
    return order == Sign::Negative ? Arc{a.branch, p, q} : Arc{a.branch, q, p};
}

// --- Points and branches. ------------------------------------------------------------------------------

// Does a point of the circle lie on this half? The two halves are graphs of their own.
bool CurveArcs::on_half(Point p, BranchId b) const {
    const Branch& branch = branches_[b];
    if (!branch.graph) return true;
    return is_on_half(*points_[p].exact, curves_[branch.curve].exact, half_of(*branch.graph));
}

Sign CurveArcs::side_of(Point p, BranchId b) {
    p = points_.representative(p);
    if (points_.is_known_on(p, b)) return Sign::Zero;
    const auto graph = branches_[b].graph;
    const CurvePoints::Data& data = points_[p];
    if (const auto s = compare_intervals(data.y, graph->y(data.x))) {
        ++points_.decisions().by_interval;
        if (*s == Sign::Zero) points_.note_on(p, b);
        return *s;
    }
    if (data.exact && curves_[branches_[b].curve].circular()) {
        ++points_.decisions().by_exact;
        const Sign s = exact_side_of(*data.exact, curves_[branches_[b].curve].exact, half_of(*graph));
        if (s == Sign::Zero) points_.note_on(p, b);
        return s;
    }
    const auto [x, y] = points_.fine_box(p);
    if (const auto s = compare_intervals(y, graph->y(x))) {
        ++points_.decisions().by_multiprecision;
        if (*s == Sign::Zero) points_.note_on(p, b);
        return *s;
    }
    points_.assume(data.x, data.y);
    points_.note_on(p, b);
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

std::vector<CurveArcs::Point> CurveArcs::find_crossings(const Curve& c, const Curve& d) {
    std::vector<Point> points;
    for (OneRootPoint& exact : common_points(c.exact, d.exact)) {
        const Point p = points_.add(std::move(exact));
        points.push_back(p);
        for (const Curve* curve : {&c, &d})
            for (const BranchId b : curve->branches)
                if (on_half(p, b)) points_.note_on(p, b);
    }
    return points;
}

std::vector<CurveArcs::Point> CurveArcs::crossings(CurveId c, CurveId d) {
    assert(c != d && curves_[c].circular() && curves_[d].circular());
    const auto [found, is_new] = crossings_.try_emplace(std::minmax(c, d));
    if (is_new) {
        found->second = find_crossings(curves_[c], curves_[d]);
        std::sort(found->second.begin(), found->second.end(),
                  [&](Point p, Point q) { return compare_xy(p, q) == Sign::Negative; });
    }
    return found->second;
}

}  // namespace vcell
