/// What the arrangement asks of its curves: points and x-monotone arcs with exact predicates.
///
/// Sweep, overlay and point location are templates over a model of ArcGeometry and see no coordinate
/// and no equation. A model owns whatever its points and arcs refer to (curves, caches, counters), so
/// its operations may be non-const; points and arcs are cheap to copy and stay valid as long as it.
///
/// Order. Points are ordered lexicographically, by x and then by y ("xy"). Equivalently the plane is
/// sheared by an infinitesimal amount, so that no two points share an x and no arc is vertical: a
/// vertical arc runs from its lower end (left) to its upper end (right), and just right of any of its
/// points it lies above every other arc.
///
/// Arcs. An x-monotone arc is closed, has two different ends, left < right in xy, and is either
/// vertical or the graph of a continuous function over the x-range of its ends. Its ends may lie
/// anywhere: on other arcs, on other arcs' ends.
///
/// Every answer is exact. From answers that contradict each other a wrong Dcel would follow; where the
/// sweep meets the contradiction it throws InternalError.
#pragma once

#include <concepts>
#include <utility>
#include <vector>

#include "../../core/numbers/sign.hpp"

namespace vcell {

/// The common points of two arcs: isolated points in xy order, and arcs along which both run.
template <class Point, class Arc>
struct ArcIntersections {
    std::vector<Point> points;
    std::vector<Arc> overlaps;

    void clear() {
        points.clear();
        overlaps.clear();
    }
};

/// A model G offers, for points p, q and arcs a, b:
///
/// compare_xy(p, q)            Sign of p - q in xy order; Zero: the same point.
///
/// compare_y_at_x(p, a)        Sign of the height of p above a. Pre: x(p) is in the closed x-range of
///                             a. Vertical a: Negative below its lower end, Positive above its upper
///                             end, Zero between them. Zero: p lies on a.
///
/// compare_y_right_of(a, b, p) Sign of a - b in height immediately right of their common point p.
///                             Pre: p lies on both and is the right end of neither. A vertical arc is
///                             above all others. Zero: a and b coincide for a stretch from p on.
///
/// left(a), right(a)           The ends. is_vertical(a): both have the same x.
///
/// intersect(a, b, out)        Appends all common points of the closed arcs to `out`: ends that touch
///                             count, tangencies once. Where the arcs coincide for a stretch, the
///                             stretch is appended to out.overlaps (as a sub-arc, maximal) and its ends
///                             are not repeated among the points. Both lists ascend in xy.
///
/// split(a, p)                 The two sub-arcs left and right of p. Pre: p lies on a and is no end.
template <class G>
concept ArcGeometry = std::semiregular<typename G::Point> && std::semiregular<typename G::Arc> &&
    requires(G& g, const typename G::Point& p, const typename G::Arc& a,
             ArcIntersections<typename G::Point, typename G::Arc>& out) {
    { g.compare_xy(p, p) } -> std::same_as<Sign>;
    { g.compare_y_at_x(p, a) } -> std::same_as<Sign>;
    { g.compare_y_right_of(a, a, p) } -> std::same_as<Sign>;
    { g.left(a) } -> std::convertible_to<typename G::Point>;
    { g.right(a) } -> std::convertible_to<typename G::Point>;
    { g.is_vertical(a) } -> std::same_as<bool>;
    { g.intersect(a, a, out) } -> std::same_as<void>;
    { g.split(a, p) } -> std::same_as<std::pair<typename G::Arc, typename G::Arc>>;
};

}  // namespace vcell
