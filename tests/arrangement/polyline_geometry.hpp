/// A third model of ArcGeometry: chains of segments. Two of them may cross many times, overlap several times,
/// and part again where neither ends, as splines do.
#pragma once

#include <algorithm>
#include <vector>

#include "segment_geometry.hpp"

namespace vcell {

struct PolylineGeometry {
    using Point = SegmentGeometry::Point;
    /// Segments from left to right, each starting where the one before ends; a vertical one is alone.
    using Arc = std::vector<SegmentGeometry::Arc>;

    SegmentGeometry segments;

    Sign compare_xy(const Point& p, const Point& q) const { return segments.compare_xy(p, q); }
    Point left(const Arc& a) const { return a.front().left; }
    Point right(const Arc& a) const { return a.back().right; }
    bool is_vertical(const Arc& a) const { return segments.is_vertical(a.front()); }

    Sign compare_y_at_x(const Point& p, const Arc& a) const {
        for (const auto& s : a) {
            // The first segment that ends no further left than p.
            const SegmentGeometry::Wide ahead =
                SegmentGeometry::Wide{s.right.x} * p.w - SegmentGeometry::Wide{p.x} * s.right.w;
            if (ahead >= 0) return segments.compare_y_at_x(p, s);
        }
        return segments.compare_y_at_x(p, a.back());
    }
    Sign compare_y_right_of(const Arc& a, const Arc& b, const Point& p) const {
        return segments.compare_y_right_of(right_of(a, p), right_of(b, p), p);
    }
    void intersect(const Arc& a, const Arc& b, ArcIntersections<Point, Arc>& out) const {
        ArcIntersections<Point, SegmentGeometry::Arc> common;
        for (const auto& s : a) {
            for (const auto& t : b) segments.intersect(s, t, common);
        }
        for (const auto& s : common.overlaps) {  // ascending, as both chains do
            if (!out.overlaps.empty() && compare_xy(right(out.overlaps.back()), s.left) == Sign::Zero) {
                out.overlaps.back().push_back(s);
            } else {
                out.overlaps.push_back({s});
            }
        }
        std::sort(common.points.begin(), common.points.end(),
                  [&](const Point& p, const Point& q) { return compare_xy(p, q) == Sign::Negative; });
        for (const Point& p : common.points) {
            if (!out.points.empty() && compare_xy(out.points.back(), p) == Sign::Zero) continue;
            const bool on_overlap = std::any_of(out.overlaps.begin(), out.overlaps.end(), [&](const Arc& o) {
                return compare_xy(left(o), p) != Sign::Positive && compare_xy(right(o), p) != Sign::Negative;
            });
            if (!on_overlap) out.points.push_back(p);
        }
    }
    std::pair<Arc, Arc> split(const Arc& a, const Point& p) const {
        std::pair<Arc, Arc> parts;
        for (const auto& s : a) {
            if (compare_xy(s.right, p) != Sign::Positive) {
                parts.first.push_back(s);
            } else if (compare_xy(s.left, p) != Sign::Negative) {
                parts.second.push_back(s);
            } else {
                const auto [before, after] = segments.split(s, p);
                parts.first.push_back(before);
                parts.second.push_back(after);
            }
        }
        return parts;
    }

private:
    const SegmentGeometry::Arc& right_of(const Arc& a, const Point& p) const {
        return *std::find_if(a.begin(), a.end(),
                             [&](const auto& s) { return compare_xy(p, s.right) == Sign::Negative; });
    }
};

static_assert(ArcGeometry<PolylineGeometry>);

}  // namespace vcell
