// The general merge of [HE, section 2.1]: two diagrams are overlaid, and in each face of the overlay the two
// forms that are lowest there are compared.
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <variant>
#include <vector>

#include "../../arrangement/circles/circle_arcs.hpp"
#include "../../arrangement/sweep/overlay.hpp"
#include "work_diagram.hpp"

namespace vcell {

namespace {

using ArcArrangement = Arrangement<CircleArcs>;

/// The arrangement of a diagram's edges, cut where they are not x-monotone, and what its elements stand for.
struct DiagramLayer {
    ArcArrangement arrangement;
    IdVector<VertexId, WorkMesh::Index> vertices;  // none: the leftmost or rightmost point of an edge's curve
    IdVector<EdgeId, WorkMesh::Index> half_edges;  // the half-edge that runs to the right
    IdVector<FaceId, WorkMesh::Index> faces;
};

/// The elements of two arrangements in which each element of their overlay lies.
struct OverlayOrigins {
    std::vector<std::array<Feature, 2>> vertices, edges;
    std::vector<std::array<FaceId, 2>> faces;

    void vertex(VertexId, Feature a, Feature b) { vertices.push_back({a, b}); }
    void edge(EdgeId, Feature a, Feature b) { edges.push_back({a, b}); }
    void face(FaceId, FaceId a, FaceId b) { faces.push_back({a, b}); }
};

DiagramLayer make_layer(const WorkMesh& mesh, CircleArcs& geometry) {
    using Index = WorkMesh::Index;
    constexpr Index none = WorkMesh::none;
    const auto& vertices = mesh.vertices();
    const auto& edges = mesh.edges();
    const auto& half_edges = mesh.half_edges();
    const auto& faces = mesh.faces();
    struct Node {
        PointId point;
        Index vertex;
    };
    struct Piece {
        CircleArcs::Arc arc;
        std::uint32_t left, right;  // nodes
        Index half_edge;
    };
    std::vector<Node> nodes;
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> node_of(vertices.size(), none);
    std::vector<std::array<std::uint32_t, 2>> chains(
        edges.size());  // of each edge: its pieces [i, j), in order
    for (Index v = 0; v < vertices.size(); ++v) {
        if (!vertices[v].alive) continue;
        node_of[v] = static_cast<std::uint32_t>(nodes.size());
        nodes.push_back({vertices[v].point, v});
    }
    std::vector<CircleArcs::Arc> arcs;
    for (Index e = 0; e < edges.size(); ++e) {
        if (!edges[e].alive) continue;
        const FormPair c = edges[e].curve;
        const Index from = half_edges[2 * e].origin, to = half_edges[2 * e + 1].origin;
        arcs.clear();
        if (from == none) {
            geometry.cut_circle(c, arcs);
            if (arcs[0].curve != c) std::swap(arcs[0], arcs[1]);  // the first one runs to the right
        } else if (from == to) {
            const PointId p = vertices[from].point;
            const auto [left, right] = geometry.x_extremes(c);
            const PointId beyond = geometry.compare_xy(p, left) == Sign::Zero ? right : left;
            geometry.cut_arc(c, p, beyond, arcs);
            geometry.cut_arc(c, beyond, p, arcs);
        } else {
            geometry.cut_arc(c, vertices[from].point, vertices[to].point, arcs);
        }
        const auto new_node = [&](PointId p) {
            nodes.push_back({p, none});
            return static_cast<std::uint32_t>(nodes.size() - 1);
        };
        const auto first = static_cast<std::uint32_t>(pieces.size());
        const std::uint32_t start = from == none ? new_node(arcs[0].left) : node_of[from];
        std::uint32_t node = start;
        for (std::size_t i = 0; i < arcs.size(); ++i) {
            const bool rightward = arcs[i].curve == c;
            const bool last = i + 1 == arcs.size();
            const std::uint32_t end = !last          ? new_node(rightward ? arcs[i].right : arcs[i].left)
                                      : from == none ? start
                                                     : node_of[to];
            if (rightward)
                pieces.push_back({arcs[i], node, end, 2 * e});
            else
                pieces.push_back({arcs[i], end, node, 2 * e + 1});
            node = end;
        }
        chains[e] = {first, static_cast<std::uint32_t>(pieces.size())};
    }

    std::vector<std::uint32_t> order(nodes.size()), rank(nodes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, [&](std::uint32_t i, std::uint32_t j) {
        return i != j && geometry.compare_xy(nodes[i].point, nodes[j].point) == Sign::Negative;
    });
    DiagramLayer layer;
    Dcel& dcel = layer.arrangement.dcel;
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        rank[order[i]] = i;
        dcel.add_vertex();
        layer.arrangement.points.push_back(nodes[order[i]].point);
        layer.vertices.push_back(nodes[order[i]].vertex);
    }
    std::vector<std::uint32_t> piece_order(pieces.size()), edge_of(pieces.size());
    std::iota(piece_order.begin(), piece_order.end(), 0u);
    std::ranges::sort(piece_order, [&](std::uint32_t i, std::uint32_t j) {
        const Piece &a = pieces[i], &b = pieces[j];
        if (a.left != b.left) return rank[a.left] < rank[b.left];
        return i != j && geometry.compare_y_right_of(a.arc, b.arc, nodes[a.left].point) == Sign::Negative;
    });
    for (std::uint32_t i = 0; i < piece_order.size(); ++i) {
        const Piece& piece = pieces[piece_order[i]];
        edge_of[piece_order[i]] = i;
        dcel.add_edge({rank[piece.left]}, {rank[piece.right]});
        layer.arrangement.arcs.push_back(piece.arc);
        layer.half_edges.push_back(piece.half_edge);
    }

    // Half-edge h becomes its edge's pieces, run in its direction.
    const auto piece_half_edge = [&](std::uint32_t i, Index h) {
        return Dcel::half_edge(EdgeId{edge_of[i]}, pieces[i].half_edge == h ? 0 : 1);
    };
    const auto first_of = [&](Index h) {
        return piece_half_edge(h & 1u ? chains[h >> 1][1] - 1 : chains[h >> 1][0], h);
    };
    const auto last_of = [&](Index h) {
        return piece_half_edge(h & 1u ? chains[h >> 1][0] : chains[h >> 1][1] - 1, h);
    };
    Index rim = none;
    for (Index e = 0; e < edges.size(); ++e) {
        if (!edges[e].alive) continue;
        for (std::uint32_t i = chains[e][0]; i + 1 < chains[e][1]; ++i) {
            dcel.link(piece_half_edge(i, 2 * e), piece_half_edge(i + 1, 2 * e));
            dcel.link(piece_half_edge(i + 1, 2 * e + 1), piece_half_edge(i, 2 * e + 1));
        }
        for (const Index h : {2 * e, 2 * e + 1}) dcel.link(last_of(h), first_of(half_edges[h].next));
        if (edges[e].rim) rim = e;
    }
    layer.faces.push_back(WorkMesh::outside);
    dcel.add_inner_ccb(Dcel::unbounded_face(), first_of(2 * rim + 1));
    for (Index f = 1; f < faces.size(); ++f) {
        if (!faces[f].alive) continue;
        const FaceId face = dcel.add_face();
        layer.faces.push_back(f);
        dcel.add_outer_ccb(face, first_of(faces[f].outer));
        for (const Index h : faces[f].inner) dcel.add_inner_ccb(face, first_of(h));
        for (const Index v : faces[f].isolated) dcel.add_isolated_vertex(face, VertexId{rank[node_of[v]]});
    }
    return layer;
}

}  // namespace

void WorkDiagram::merge(const WorkDiagram& defender, const WorkDiagram& challenger) {
    CircleArcs geometry(kernel_);
    const std::array<const WorkDiagram*, 2> sources{&defender, &challenger};
    const std::array<DiagramLayer, 2> layers{make_layer(defender, geometry),
                                             make_layer(challenger, geometry)};
    OverlayOrigins origins;
    const ArcArrangement overlaid = overlay(geometry, layers[0].arrangement, layers[1].arrangement, origins);
    const Dcel& dcel = overlaid.dcel;

    clear();
    duels_.clear();
    const auto site = [&](FaceId f, int side) {
        return sources[side]->faces_[layers[side].faces[origins.faces[f.value][side]]].site;
    };
    const auto take_ties = [&](Index list, int side) {
        if (list == none) return none;
        ties_.push_back(sources[side]->ties_[list]);
        return static_cast<Index>(ties_.size() - 1);
    };

    for (std::uint32_t i = 0; i < dcel.vertex_count(); ++i) {
        HalfEdgeId h = dcel.outgoing({i});
        const bool isolated = !h.valid();
        while (!isolated && dcel.face(h) == Dcel::unbounded_face()) h = dcel.next_around_origin(h);
        const Index v = add_vertex(overlaid.points[VertexId{i}],
                                   site(isolated ? dcel.isolated_in({i}) : dcel.face(h), 0));
        if (isolated) --live_vertices_;
        std::array<Index, 2> ties{none, none};
        for (const int side : {0, 1}) {
            const VertexId* from = std::get_if<VertexId>(&origins.vertices[i][side]);
            const Index w = from ? layers[side].vertices[*from] : none;
            if (w != none) ties[side] = take_ties(sources[side]->vertices_[w].ties, side);
        }
        vertices_[v].ties = ties[0];
        vertices_[v].challenger_ties = ties[1];
    }

    // Rim edges may have to turn round: the region lies left of half-edge 2e.
    const auto turned = [&](HalfEdgeId h) {
        return dcel.face(Dcel::half_edge(Dcel::edge(h))) == Dcel::unbounded_face();
    };
    const auto mine = [&](HalfEdgeId h) -> Index { return turned(h) ? h.value ^ 1u : h.value; };
    for (std::uint32_t i = 0; i < dcel.edge_count(); ++i) {
        const HalfEdgeId right = Dcel::half_edge({i}), forward = turned(right) ? Dcel::twin(right) : right;
        FormPair curve;
        std::array<Index, 2> ties{none, none};
        for (const int side : {1, 0}) {
            const EdgeId* from = std::get_if<EdgeId>(&origins.edges[i][side]);
            if (!from) continue;
            const Index h = layers[side].half_edges[*from];
            curve = sources[side]->directed(turned(right) ? h ^ 1u : h);
            ties[side] = take_ties(sources[side]->edges_[h >> 1].ties, side);
        }
        const bool rim = dcel.face(Dcel::twin(forward)) == Dcel::unbounded_face();
        const Index e = add_edge(curve, dcel.origin(forward).value, dcel.target(forward).value, rim);
        edges_[e].ties = ties[0];
        edges_[e].challenger_ties = ties[1];
        set_bounds(e);
    }
    for (std::uint32_t i = 0; i < dcel.half_edge_count(); ++i) {
        const HalfEdgeId h{i};
        HalfEdge& half = half_edges_[mine(h)];
        half.next = mine(dcel.next(h));
        half.prev = mine(dcel.prev(h));
        half.face = dcel.face(h).value;
        if (half.face != outside) half.label = site(dcel.face(h), 0);
        vertices_[half.origin].out = mine(h);
    }
    live_cycles_ = static_cast<long>(dcel.ccb_count());

    add_face({});
    for (std::uint32_t i = 0; i < dcel.face_count(); ++i) {
        const FaceId id{i};
        const Index f = i == outside ? outside : add_face(site(id, 0));
        Face& face = faces_[f];
        for (const CcbId c : dcel.inner_ccbs(id)) face.inner.push_back(mine(dcel.start(c)));
        if (f == outside) continue;
        face.outer = mine(dcel.start(dcel.outer_ccb(id)));
        for (const VertexId v : dcel.isolated_vertices(id)) {
            face.isolated.push_back(v.value);
            vertices_[v.value].isolated_in = f;
        }
        for_cycle(face.outer, [&](Index h) { grow(face.box, edges_[h >> 1].bounds.box); });
        duels_.push_back({f, site(id, 1)});
    }

    merging_ = true;
    begin();
    for (Duel& d : duels_) decide_boundary(d);
    unite_ties();
    divide_faces();
    merging_ = false;
}

// Once signs are known, before arcs are inserted: the forms that attain the minimum at vertices and edges of
// the overlay are those of the winner, and of both where they tie.
void WorkDiagram::unite_ties() {
    // Duel i is that of face i + 1.
    const auto challenger = [&](Index face) {
        return face == outside ? FormId() : duels_[face - 1].challenger;
    };
    std::vector<FormId> all;
    const auto gather = [&](Index list) {
        if (list != none) all.insert(all.end(), ties_[list].begin(), ties_[list].end());
    };
    const auto gather_sides = [&](Index e) {
        for (const Index h : {2 * e, 2 * e + 1}) {
            all.push_back(half_edges_[h].label);
            all.push_back(challenger(half_edges_[h].face));
        }
        gather(edges_[e].ties);
        gather(edges_[e].challenger_ties);
    };
    const auto store = [&] {
        std::erase_if(all, [](FormId f) { return !f.valid(); });
        std::ranges::sort(all);
        all.erase(std::ranges::unique(all).begin(), all.end());
        ties_.push_back(all);
        return static_cast<Index>(ties_.size() - 1);
    };
    // Vertices first: they gather from edges what those had before.
    for (Vertex& v : vertices_) {
        if (v.sign == Sign::Positive) continue;
        all.clear();
        gather(v.challenger_ties);
        if (v.sign == Sign::Negative) {
            FormId lowest = v.out == none ? challenger(v.isolated_in) : FormId();
            for (Index h = v.out; !lowest.valid(); h = next_around_origin(h))
                lowest = challenger(half_edges_[h].face);
            set_height(v, lowest);
            v.ties = all.empty() ? none : store();
            continue;
        }
        gather(v.ties);
        if (v.out == none) {
            all.push_back(faces_[v.isolated_in].site);
            all.push_back(challenger(v.isolated_in));
        } else {
            for_leaving(v.out, [&](Index h) { gather_sides(h >> 1); });
        }
        v.ties = store();
    }
    for (Index e = 0; e < edges_.size(); ++e) {
        Edge& edge = edges_[e];
        if (edge.sign == Sign::Positive) continue;
        all.clear();
        if (edge.sign == Sign::Negative)
            gather(edge.challenger_ties);
        else
            gather_sides(e);
        edge.ties = all.empty() ? none : store();
    }
}

}  // namespace vcell
