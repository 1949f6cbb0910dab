/// Checks of an arrangement against its geometry: what Dcel::find_defect cannot see.
#pragma once

#include <doctest/doctest.h>

#include <ostream>
#include <string>
#include <vector>

#include "vcell/arrangement/sweep/point_location.hpp"

namespace vcell {

/// The feature that holds p, by looking at every vertex and edge.
template <ArcGeometry G>
Feature locate_by_walk(G& geometry, const Arrangement<G>& arrangement, const typename G::Point& p) {
    for (const VertexId v : arrangement.points.ids()) {
        if (geometry.compare_xy(p, arrangement.points[v]) == Sign::Zero) return v;
    }
    EdgeId below;
    for (const EdgeId e : arrangement.arcs.ids()) {
        const auto& arc = arrangement.arcs[e];
        if (geometry.compare_xy(p, geometry.left(arc)) == Sign::Negative) continue;
        if (geometry.compare_xy(p, geometry.right(arc)) == Sign::Positive) continue;
        const Sign side = geometry.compare_y_at_x(p, arc);
        if (side == Sign::Zero) return e;
        if (side == Sign::Negative) continue;
        if (!below.valid()) {
            below = e;
            continue;
        }
        // Both arcs pass below p and do not cross: their order is that where the later one begins.
        const auto& other = arrangement.arcs[below];
        const auto left = geometry.left(arc), other_left = geometry.left(other);
        const Sign order = geometry.compare_xy(left, other_left);
        const Sign height = order == Sign::Positive   ? geometry.compare_y_at_x(left, other)
                            : order == Sign::Negative ? -geometry.compare_y_at_x(other_left, arc)
                                                      : geometry.compare_y_right_of(arc, other, left);
        if (height == Sign::Positive) below = e;
    }
    return below.valid() ? arrangement.dcel.face(Dcel::half_edge(below)) : Dcel::unbounded_face();
}

/// The first thing that is wrong with the arrangement, or an empty string. O(E^2) intersections.
template <ArcGeometry G>
std::string arrangement_defect(G& g, const Arrangement<G>& a) {
    if (const auto defect = a.dcel.find_defect()) return defect->what;
    if (a.points.size() != a.dcel.vertex_count()) return "points and vertices differ in number";
    if (a.arcs.size() != a.dcel.edge_count()) return "arcs and edges differ in number";
    for (std::uint32_t v = 1; v < a.points.size(); ++v) {
        if (g.compare_xy(a.points[VertexId{v - 1}], a.points[VertexId{v}]) != Sign::Negative) {
            return to_string(VertexId{v}) + " is not after its predecessor";
        }
    }
    for (const EdgeId e : a.arcs.ids()) {
        const HalfEdgeId h = Dcel::half_edge(e);
        if (g.compare_xy(g.left(a.arcs[e]), a.points[a.dcel.origin(h)]) != Sign::Zero ||
            g.compare_xy(g.right(a.arcs[e]), a.points[a.dcel.target(h)]) != Sign::Zero) {
            return to_string(e) + " does not end where its arc does";
        }
        if (e.value == 0) continue;
        const EdgeId before{e.value - 1};
        const VertexId left = a.dcel.origin(h), left_before = a.dcel.origin(Dcel::half_edge(before));
        if (left < left_before) return to_string(e) + " starts left of its predecessor";
        if (left == left_before &&
            g.compare_y_right_of(a.arcs[before], a.arcs[e], a.points[left]) != Sign::Negative) {
            return to_string(e) + " is not above its predecessor";
        }
    }
    ArcIntersections<typename G::Point, typename G::Arc> common;
    for (const EdgeId e : a.arcs.ids()) {
        for (EdgeId f{0}; f < e; ++f.value) {
            common.clear();
            g.intersect(a.arcs[e], a.arcs[f], common);
            if (!common.overlaps.empty()) return to_string(e) + " and " + to_string(f) + " overlap";
            for (const auto& p : common.points) {
                for (const EdgeId i : {e, f}) {
                    if (g.compare_xy(p, g.left(a.arcs[i])) != Sign::Zero &&
                        g.compare_xy(p, g.right(a.arcs[i])) != Sign::Zero) {
                        return to_string(e) + " and " + to_string(f) + " meet inside " + to_string(i);
                    }
                }
            }
        }
        for (const VertexId v : a.points.ids()) {
            const auto& p = a.points[v];
            if (g.compare_xy(p, g.left(a.arcs[e])) == Sign::Positive &&
                g.compare_xy(p, g.right(a.arcs[e])) == Sign::Negative &&
                g.compare_y_at_x(p, a.arcs[e]) == Sign::Zero) {
                return to_string(v) + " lies inside " + to_string(e);
            }
        }
    }
    return {};
}

/// How often the components of a face run around p, by counting half-edges above p: 1 in total for a point of
/// a bounded face, 0 for one of the unbounded face. Pre: p lies on no vertex or edge.
template <ArcGeometry G>
int winding_number(G& g, const Arrangement<G>& a, FaceId face, const typename G::Point& p) {
    int winding = 0;
    for (std::uint32_t i = 0; i < a.dcel.half_edge_count(); ++i) {
        const HalfEdgeId h{i};
        const auto& arc = a.arcs[Dcel::edge(h)];
        if (a.dcel.face(h) != face) continue;
        // In the sheared plane an upward ray meets the arcs whose xy-range holds p.
        if (g.compare_xy(p, g.left(arc)) == Sign::Negative || g.compare_xy(p, g.right(arc)) != Sign::Negative)
            continue;
        if (g.compare_y_at_x(p, arc) == Sign::Negative) winding += h.value % 2 == 0 ? -1 : 1;
    }
    return winding;
}

/// Compares the locator with the walk, and faces with winding numbers.
template <ArcGeometry G>
void check_location(G& g, const Arrangement<G>& a, const std::vector<typename G::Point>& points) {
    const PointLocator<G> locator(g, a);
    for (const auto& p : points) {
        const Feature found = locator.locate(p);
        REQUIRE(found == locate_by_walk(g, a, p));
        if (const FaceId* f = std::get_if<FaceId>(&found)) {
            REQUIRE(winding_number(g, a, *f, p) == (*f == Dcel::unbounded_face() ? 0 : 1));
        }
    }
}

/// Number of connected components, from Euler's relation.
inline long component_count(const Dcel& d) {
    return static_cast<long>(d.vertex_count()) - static_cast<long>(d.edge_count()) +
           static_cast<long>(d.face_count()) - 1;
}

/// Sizes of an arrangement.
struct Counts {
    std::size_t vertices = 0, edges = 0;
    long components = 0;
    friend bool operator==(const Counts&, const Counts&) = default;
};
inline std::ostream& operator<<(std::ostream& out, const Counts& c) {
    return out << "V " << c.vertices << " E " << c.edges << " C " << c.components;
}

/// Equal topology, element by element. Arrangements of equal geometry have it whatever their history:
/// vertices and edges are numbered by the geometry, and so are faces.
inline bool same_topology(const Dcel& a, const Dcel& b) {
    if (a.vertex_count() != b.vertex_count() || a.edge_count() != b.edge_count() ||
        a.face_count() != b.face_count() || a.ccb_count() != b.ccb_count()) {
        return false;
    }
    for (std::uint32_t i = 0; i < a.half_edge_count(); ++i) {
        const HalfEdgeId h{i};
        if (a.origin(h) != b.origin(h) || a.next(h) != b.next(h) || a.face(h) != b.face(h) ||
            a.is_outer(a.ccb(h)) != b.is_outer(b.ccb(h))) {
            return false;
        }
    }
    for (std::uint32_t v = 0; v < a.vertex_count(); ++v) {
        if (a.isolated_in(VertexId{v}) != b.isolated_in(VertexId{v})) return false;
    }
    return true;
}

}  // namespace vcell
