/// Doubly connected edge list: the topology of a planar subdivision, without any geometry.
///
/// Half-edges 2e and 2e+1 are the twins of edge e. A half-edge has its face on its left. The boundary
/// of a face is a set of connected components (CCBs): at most one outer CCB, run counter-clockwise,
/// any number of inner CCBs, run clockwise, and isolated vertices. The unbounded face has no outer
/// CCB. A closed edge without vertices is a half-edge that is its own next, with no origin.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../../core/ids.hpp"

namespace vcell {

struct VertexTag {
    static constexpr char letter = 'v';
};
struct HalfEdgeTag {
    static constexpr char letter = 'h';
};
struct EdgeTag {
    static constexpr char letter = 'e';
};
struct CcbTag {
    static constexpr char letter = 'c';
};
struct FaceTag {
    static constexpr char letter = 'f';
};

using VertexId = Id<VertexTag>;
using HalfEdgeId = Id<HalfEdgeTag>;
using EdgeId = Id<EdgeTag>;
using CcbId = Id<CcbTag>;
using FaceId = Id<FaceTag>;

/// The first broken invariant that find_defect() met, in words that name the elements.
struct DcelDefect {
    std::string what;
};

class Dcel {
public:
    static HalfEdgeId twin(HalfEdgeId h) { return {h.value ^ 1u}; }
    static EdgeId edge(HalfEdgeId h) { return {h.value >> 1}; }
    /// The half-edge 2e (direction 0) or 2e+1 (direction 1).
    static HalfEdgeId half_edge(EdgeId e, unsigned direction = 0) { return {2 * e.value + direction}; }

    HalfEdgeId next(HalfEdgeId h) const { return half_edges_[h].next; }
    HalfEdgeId prev(HalfEdgeId h) const { return half_edges_[h].prev; }
    VertexId origin(HalfEdgeId h) const { return half_edges_[h].origin; }
    VertexId target(HalfEdgeId h) const { return origin(twin(h)); }
    CcbId ccb(HalfEdgeId h) const { return half_edges_[h].ccb; }
    FaceId face(HalfEdgeId h) const { return ccbs_[ccb(h)].face; }
    FaceId face(CcbId c) const { return ccbs_[c].face; }
    /// Some half-edge of the component.
    HalfEdgeId start(CcbId c) const { return ccbs_[c].start; }
    bool is_outer(CcbId c) const { return ccbs_[c].outer; }

    /// Some half-edge that leaves v; none when v is isolated.
    HalfEdgeId outgoing(VertexId v) const { return vertices_[v].outgoing; }
    /// The next half-edge leaving the same origin, counter-clockwise.
    HalfEdgeId next_around_origin(HalfEdgeId h) const { return twin(prev(h)); }
    /// The face that holds isolated vertex v; none when v has edges.
    FaceId isolated_in(VertexId v) const { return vertices_[v].isolated_in; }

    /// None for the unbounded face only.
    CcbId outer_ccb(FaceId f) const { return faces_[f].outer; }
    const std::vector<CcbId>& inner_ccbs(FaceId f) const { return faces_[f].inner; }
    const std::vector<VertexId>& isolated_vertices(FaceId f) const { return faces_[f].isolated; }

    std::size_t vertex_count() const { return vertices_.size(); }
    std::size_t edge_count() const { return half_edges_.size() / 2; }
    std::size_t half_edge_count() const { return half_edges_.size(); }
    std::size_t ccb_count() const { return ccbs_.size(); }
    std::size_t face_count() const { return faces_.size(); }
    static constexpr FaceId unbounded_face() { return {0}; }

    // --- Construction: links first, then components, then faces. -------------------------------

    Dcel();  ///< one face, the unbounded one
    void reserve(std::size_t vertices, std::size_t edges, std::size_t faces);
    VertexId add_vertex();
    /// An edge from `from` to `to`, not linked yet. Both none: a closed edge, linked to itself.
    EdgeId add_edge(VertexId from, VertexId to);
    /// Makes `second` follow `first` on their common component. Pre: target(first) == origin(second).
    void link(HalfEdgeId first, HalfEdgeId second) {
        half_edges_[first].next = second;
        half_edges_[second].prev = first;
    }
    FaceId add_face();
    /// Declares the cycle through `start` a component of f; every half-edge on it is marked.
    CcbId add_outer_ccb(FaceId f, HalfEdgeId start) { return add_ccb(f, start, true); }
    CcbId add_inner_ccb(FaceId f, HalfEdgeId start) { return add_ccb(f, start, false); }
    void add_isolated_vertex(FaceId f, VertexId v);

    /// The first broken invariant: twins, next/prev, origins, component membership, the rotation of
    /// half-edges around each vertex, isolated vertices, and Euler's relation V - E + F = 1 + C.
    std::optional<DcelDefect> find_defect() const;

private:
    struct Vertex {
        HalfEdgeId outgoing;
        FaceId isolated_in;
    };
    struct HalfEdge {
        HalfEdgeId next, prev;
        VertexId origin;
        CcbId ccb;
    };
    struct Ccb {
        FaceId face;
        HalfEdgeId start;
        bool outer;
    };
    struct Face {
        CcbId outer;
        std::vector<CcbId> inner;
        std::vector<VertexId> isolated;
    };

    CcbId add_ccb(FaceId f, HalfEdgeId start, bool outer);

    IdVector<VertexId, Vertex> vertices_;
    IdVector<HalfEdgeId, HalfEdge> half_edges_;
    IdVector<CcbId, Ccb> ccbs_;
    IdVector<FaceId, Face> faces_;
};

}  // namespace vcell
