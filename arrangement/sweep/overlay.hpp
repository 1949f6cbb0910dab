/// Overlay of two arrangements, with the caller's meaning for every new element.
#pragma once

#include <cassert>
#include <concepts>
#include <variant>
#include <vector>

#include "sweep.hpp"

namespace vcell {

/// An element of an arrangement: what a point lies on.
using Feature = std::variant<VertexId, EdgeId, FaceId>;

/// Told for each element of an overlay which elements of the two arrangements it comes from: the one
/// whose relative interior holds the element's. An edge comes from edges and faces, a face from faces.
/// The calls come after the topology is complete: vertices, edges, faces, each kind in ascending order.
template <class T>
concept OverlayTraits = requires(T& t, Feature a, Feature b) {
    t.vertex(VertexId(), a, b);
    t.edge(EdgeId(), a, b);
    t.face(FaceId(), FaceId(), FaceId());
};

/// For those who want the union of the edges and no more.
struct NoOverlayTraits {
    void vertex(VertexId, Feature, Feature) {}
    void edge(EdgeId, Feature, Feature) {}
    void face(FaceId, FaceId, FaceId) {}
};

namespace detail {

/// The face of an input in which each face of the overlay lies. `edge_in_input` gives for each edge of the
/// overlay the edge of the input along which it runs, or none.
IdVector<FaceId, FaceId> faces_in_input(const Dcel& overlay, const Dcel& input,
                                        const IdVector<EdgeId, EdgeId>& edge_in_input);

}  // namespace detail

/// The arrangement of all edges and vertices of `a` and `b`. Edges of one input are never compared with
/// each other; what the two have in common is recognised by compare_xy and by overlaps.
template <ArcGeometry G, OverlayTraits T = NoOverlayTraits>
Arrangement<G> overlay(G& geometry, const Arrangement<G>& a, const Arrangement<G>& b, T&& traits = {}) {
    SweepInput<G> input;
    input.add_layer(a, 0);
    input.add_layer(b, 1);
    SweepResult<G> swept = sweep(geometry, input);
    const Dcel& dcel = swept.arrangement.dcel;

    const auto first_point = static_cast<std::uint32_t>(a.points.size());
    const auto first_arc = static_cast<std::uint32_t>(a.arcs.size());
    const auto edge_from = [&](std::uint32_t arc) {
        return std::pair{arc >= first_arc, EdgeId{arc >= first_arc ? arc - first_arc : arc}};
    };

    std::array<IdVector<EdgeId, EdgeId>, 2> edges;
    for (auto& list : edges) list.resize(dcel.edge_count());
    for (std::uint32_t e = 0; e < dcel.edge_count(); ++e) {
        for (const std::uint32_t arc : swept.edge_arcs[e]) {
            const auto [which, edge] = edge_from(arc);
            edges[which][EdgeId{e}] = edge;
        }
    }
    const std::array faces{detail::faces_in_input(dcel, a.dcel, edges[0]),
                           detail::faces_in_input(dcel, b.dcel, edges[1])};

    for (std::uint32_t i = 0; i < dcel.vertex_count(); ++i) {
        const VertexId v{i};
        // Without a vertex or an edge of an input at v, the faces around v lie in one face of it.
        const HalfEdgeId h = dcel.outgoing(v);
        const FaceId f = h.valid() ? dcel.face(h) : dcel.isolated_in(v);
        std::array<Feature, 2> from{faces[0][f], faces[1][f]};
        for (const std::uint32_t arc : swept.vertex_arcs[i]) {
            const auto [which, edge] = edge_from(arc);
            from[which] = edge;
        }
        for (const std::uint32_t p : swept.vertex_points[i]) {
            from[p >= first_point] = VertexId{p >= first_point ? p - first_point : p};
        }
        traits.vertex(v, from[0], from[1]);
    }
    for (std::uint32_t i = 0; i < dcel.edge_count(); ++i) {
        const EdgeId e{i};
        const FaceId f = dcel.face(Dcel::half_edge(e));
        std::array<Feature, 2> from{faces[0][f], faces[1][f]};
        for (int which = 0; which < 2; ++which) {
            if (edges[which][e].valid()) from[which] = edges[which][e];
        }
        traits.edge(e, from[0], from[1]);
    }
    for (std::uint32_t i = 0; i < dcel.face_count(); ++i)
        traits.face(FaceId{i}, faces[0][FaceId{i}], faces[1][FaceId{i}]);
    return std::move(swept.arrangement);
}

}  // namespace vcell
