/// Arcs of lines, circles, rational Bezier and B-spline curves in any mix: a model of ArcGeometry.
///
/// Every x-monotone piece of a curve is a MonotoneGraph y(x). Two of them are intersected once, by isolating
/// the zeros of the difference of their heights: parts of the common x-range are halved until over each of
/// them the difference has no zero, or is strictly monotone. All other answers follow from the zeros of each
/// pair and from the differences' signs between them, so they do not contradict each other.
///
/// Signs climb the ladder: double intervals, exact numbers among lines and circles, 320-bit intervals.
/// Differences below 2^-200 of the scale of the arcs' coordinates, and what 320 bits cannot tell, are assumed
/// to be zero and counted.
///
/// Which points are one, and on which pieces they lie, CurvePoints knows.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../core/ids.hpp"
#include "../sweep/arc_geometry.hpp"
#include "curve_points.hpp"
#include "monotone_graph.hpp"

namespace vcell {

struct CurveTag {
    static constexpr char letter = 'k';
};
using CurveId = Id<CurveTag>;

class CurveArcs {
public:
    using Point = CurvePointId;
    /// A piece of a branch: of a line, of half a circle, of a Bezier curve between its turns in x.
    struct Arc {
        BranchId branch;
        Point left, right;
    };
    // --- Curves. Equal lines, circles and Bezier curves become one curve. ------------------------------

    /// k |p - c|^2 + a x + b y + e = 0, the doubles being exact (w is ignored).
    /// Pre: a line, or a circle of positive radius.
    CurveId add_circular(const CircularForm& form);
    CurveId add_line(double a, double b, double e) { return add_circular({.a = a, .b = b, .e = e}); }
    CurveId add_circle(double cx, double cy, double squared_radius) {
        return add_circular({.k = 1, .cx = cx, .cy = cy, .e = -squared_radius});
    }
    /// Control points (x, y, w), exact. Pre: degree 1 to 16, w > 0; x is not constant (add_line).
    CurveId add_bezier(std::vector<Eigen::Vector3d> points);
    /// The spans of a rational B-spline, in order: Bezier curves, whose control points are rounded once and
    /// shared where spans meet. Pre: that of add_bezier for each.
    std::vector<CurveId> add_spline(RationalCurve2 curve);

    // --- Points and arcs of them. ----------------------------------------------------------------------

    /// A point given by exact coordinates.
    Point point(double x, double y) { return points_.add(x, y); }
    /// The common points of two different lines or circles, ascending; exact.
    std::vector<Point> crossings(CurveId c, CurveId d);
    /// Appends the whole curve as x-monotone arcs. Pre: c is no line.
    void cut(CurveId c, std::vector<Arc>& out) const;
    /// Pre: p and q are different points of the line.
    Arc segment(CurveId line, Point p, Point q);
    /// The part of an arc between two different points on it.
    Arc sub_arc(const Arc& a, Point p, Point q);

    /// A box of doubles around the point.
    std::array<Interval, 2> box(Point p) const { return {points_[p].x, points_[p].y}; }
    /// A box of 320-bit numbers around it.
    std::pair<Wide, Wide> fine_box(Point p) { return points_.fine_box(p); }
    const Decisions& decisions() const { return points_.decisions(); }
    /// Where a coincidence was assumed, one point for each in the order of the decisions.
    const std::vector<Eigen::Vector2d>& assumed_at() const { return points_.assumed_at(); }

    // --- ArcGeometry. ----------------------------------------------------------------------------------

    Sign compare_xy(Point p, Point q) { return points_.compare_xy(p, q); }
    Sign compare_y_at_x(Point p, const Arc& a);
    Sign compare_y_right_of(const Arc& a, const Arc& b, Point p);
    Point left(const Arc& a) const { return a.left; }
    Point right(const Arc& a) const { return a.right; }
    bool is_vertical(const Arc& a) const { return !branches_[a.branch].graph; }
    void intersect(const Arc& a, const Arc& b, ArcIntersections<Point, Arc>& out);
    std::pair<Arc, Arc> split(const Arc& a, Point p) const {
        return {{a.branch, a.left, p}, {a.branch, p, a.right}};
    }

private:
    class Isolation;

    struct Branch {
        CurveId curve;
        std::shared_ptr<const MonotoneGraph> graph;  // none: vertical
        Point left, right;                           // none: a line
        Point anchor;                                // of a vertical line: some point on it
    };
    struct Curve {
        enum class Kind : std::uint8_t { Line, Circle, Bezier } kind;
        std::vector<BranchId> branches;
        CircularForm form;
        ExactForm exact;
        std::shared_ptr<const RationalBezier> bezier;
        bool circular() const { return kind == Kind::Line || kind == Kind::Circle; }
    };
    /// The common points of two branches a < b, ascending, and the sign of a - b in height left of each of
    /// them and right of the last. Zero: not in the common range. Branches that coincide have neither.
    struct Meeting {
        bool coincide = false;
        std::vector<Point> points;
        std::vector<Sign> signs;
    };

    BranchId add_branch(CurveId c, std::shared_ptr<const MonotoneGraph> graph, Point left, Point right);
    Sign side_of(Point p, BranchId b);
    bool on_half(Point p, BranchId b) const;

    const Meeting& meeting(BranchId a, BranchId b);
    Meeting meet(BranchId a, BranchId b);
    Meeting meet_vertical(BranchId vertical, BranchId b);
    Meeting with_signs_between(BranchId a, BranchId b, std::vector<Point> points);
    Sign sign_between(BranchId a, BranchId b, std::optional<Point> l, std::optional<Point> r);
    std::vector<Point> find_crossings(const Curve& c, const Curve& d);
    std::optional<Point> later_left(BranchId a, BranchId b);
    std::optional<Point> earlier_right(BranchId a, BranchId b);

    CurvePoints points_;
    IdVector<CurveId, Curve> curves_;
    IdVector<BranchId, Branch> branches_;
    std::map<std::pair<CurveId, CurveId>, std::vector<Point>> crossings_;
    std::map<std::pair<BranchId, BranchId>, Meeting> meetings_;
};

static_assert(ArcGeometry<CurveArcs>);

}  // namespace vcell
