/// A second model of ArcGeometry, to prove that the arrangement is generic: line segments between
/// integer points. Everything is an integer: a point is (x : y : w), computed from the original segments
/// only, so that no number grows beyond the bounds below.
#pragma once

#include <cassert>
#include <cstdint>
#include <tuple>
#include <utility>

#include "vcell/arrangement/sweep/arc_geometry.hpp"

namespace vcell {

struct SegmentGeometry {
    /// Coordinates of end points are in [0, max_coordinate]: then |x|, |y| < 2^62, w < 2^41, and what the
    /// predicates compare stays below 2^104.
    static constexpr std::int64_t max_coordinate = 1 << 19;
    __extension__ using Wide = __int128;

    struct Point {
        std::int64_t x = 0, y = 0, w = 1;  ///< w > 0
    };
    struct Arc {
        std::int64_t dx = 0, dy = 0, c = 0;  ///< line: dx y - dy x + c = 0, left to right
        Point left, right;
    };

    static Arc segment(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
        assert(std::tie(x0, y0) != std::tie(x1, y1));
        if (std::tie(x1, y1) < std::tie(x0, y0)) {
            std::swap(x0, x1);
            std::swap(y0, y1);
        }
        const std::int64_t dx = x1 - x0, dy = y1 - y0;
        return {dx, dy, dy * x0 - dx * y0, {x0, y0, 1}, {x1, y1, 1}};
    }

    Sign compare_xy(const Point& p, const Point& q) const {
        const Sign s = sign_of(Wide{p.x} * q.w - Wide{q.x} * p.w);
        return s != Sign::Zero ? s : sign_of(Wide{p.y} * q.w - Wide{q.y} * p.w);
    }
    Sign compare_y_at_x(const Point& p, const Arc& a) const {
        if (!is_vertical(a)) return side(p, a);
        if (compare_xy(p, a.left) == Sign::Negative) return Sign::Negative;
        return compare_xy(p, a.right) == Sign::Positive ? Sign::Positive : Sign::Zero;
    }
    Sign compare_y_right_of(const Arc& a, const Arc& b, const Point&) const { return turn(b, a); }
    Point left(const Arc& a) const { return a.left; }
    Point right(const Arc& a) const { return a.right; }
    bool is_vertical(const Arc& a) const { return a.dx == 0; }

    void intersect(const Arc& a, const Arc& b, ArcIntersections<Point, Arc>& out) const {
        const Sign parallel = turn(a, b);
        const Sign left_of_b = side(b.left, a), right_of_b = side(b.right, a);
        if (parallel == Sign::Zero) {
            if (left_of_b != Sign::Zero) return;
            const Point from = compare_xy(a.left, b.left) == Sign::Negative ? b.left : a.left;
            const Point to = compare_xy(a.right, b.right) == Sign::Negative ? a.right : b.right;
            const Sign order = compare_xy(from, to);
            if (order == Sign::Zero) out.points.push_back(from);
            if (order == Sign::Negative) out.overlaps.push_back({a.dx, a.dy, a.c, from, to});
            return;
        }
        if (left_of_b * right_of_b == Sign::Positive ||
            side(a.left, b) * side(a.right, b) == Sign::Positive) {
            return;
        }
        // Cramer on dx y - dy x = -c.
        std::int64_t w = a.dx * b.dy - a.dy * b.dx;
        std::int64_t x = b.dx * a.c - a.dx * b.c, y = b.dy * a.c - a.dy * b.c;
        if (w > 0) {
            out.points.push_back({-x, -y, w});
        } else {
            out.points.push_back({x, y, -w});
        }
    }
    std::pair<Arc, Arc> split(const Arc& a, const Point& p) const {
        return {{a.dx, a.dy, a.c, a.left, p}, {a.dx, a.dy, a.c, p, a.right}};
    }

    /// Positive: p lies left of the line's direction (above, unless it is vertical).
    static Sign side(const Point& p, const Arc& a) {
        return sign_of(Wide{a.dx} * p.y - Wide{a.dy} * p.x + Wide{a.c} * p.w);
    }
    static Sign turn(const Arc& a, const Arc& b) { return sign_of(a.dx * b.dy - a.dy * b.dx); }
};

static_assert(ArcGeometry<SegmentGeometry>);

}  // namespace vcell
