#include "frozen_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "../../core/errors.hpp"
#include "../../core/sort_unique.hpp"

namespace vcell {

namespace {

// The boundary components of faces, and which of a face's is its outer one. Faces and connected graphs of
// edges that touch each other form a tree, since each graph separates the faces around it; seen from a root
// face the outer component of a face is the one on the way there.
class Components {
public:
    using Index = FormMesh::Index;
    static constexpr Index none = FormMesh::none;

    explicit Components(std::size_t faces) : first_(faces, none) {}

    Index add(Index start, Index face) {
        const auto c = static_cast<Index>(items_.size());
        items_.push_back({start, face, std::exchange(first_[face], c), none});
        graphs_.add();
        return c;
    }
    Index start(Index c) const { return items_[c].start; }
    Index first(Index face) const { return first_[face]; }
    Index next(Index c) const { return items_[c].next_of_face; }
    /// Does a face other than the root have several?
    bool is_nested(Index root) const {
        return std::ranges::any_of(items_,
                                   [&](const Item& c) { return c.face != root && c.next_of_face != none; });
    }
    /// The two sides of an edge belong to one graph.
    void join(Index c, Index d) { graphs_.merge(c, d); }
    /// Pre: join() was called for all edges.
    void find_outer(Index root) {
        std::vector<Index> first_of_graph(items_.size(), none), open;
        for (Index c = 0; c < items_.size(); ++c)
            items_[c].next_of_graph = std::exchange(first_of_graph[graphs_.find(c)], c);
        outer_.assign(first_.size(), none);
        const auto enter_graphs_of = [&](Index face) {
            for (Index c = first_[face]; c != none; c = items_[c].next_of_face)
                if (const Index g = std::exchange(first_of_graph[graphs_.find(c)], none); g != none)
                    open.push_back(g);
        };
        enter_graphs_of(root);
        while (!open.empty()) {
            const Index graph = open.back();
            open.pop_back();
            for (Index c = graph; c != none; c = items_[c].next_of_graph) {
                const Index face = items_[c].face;
                if (face == root || outer_[face] != none) continue;
                outer_[face] = c;
                enter_graphs_of(face);
            }
        }
    }
    Index outer(Index face) const { return outer_.empty() ? first_[face] : outer_[face]; }

private:
    struct Item {
        Index start, face, next_of_face, next_of_graph;
    };

    std::vector<Item> items_;
    Partition graphs_;
    std::vector<Index> first_, outer_;
};

Interval height_at(const Heights& heights, const FormMesh::Vertex& v, FormId form) {
    const Interval x = Interval::ball(v.x, v.error), y = Interval::ball(v.y, v.error);
    return heights.value(form, x, y) * heights.scale(x, y);
}

// The forms of the faces around a vertex are equal there: the one whose coefficients cancel least tells the
// height best, where the first one leaves few digits.
void tell_height(const Heights& heights, const FormMesh::Vertex& v, std::span<const FormId> forms,
                 MinimizationDiagram::Vertex& to) {
    constexpr double enough_digits = 0x1p-44;
    for (const FormId f : forms) {
        if (to.height_error <= enough_digits * std::abs(to.height)) return;
        const Interval height = height_at(heights, v, f);
        if (!(height.radius() < to.height_error)) continue;
        to.height = height.mid();
        to.height_error = height.radius();
    }
}

}  // namespace

MinimizationDiagram frozen(const FormMesh& mesh, const MeshOutside& outside, const Heights& heights) {
    using Index = FormMesh::Index;
    constexpr Index none = FormMesh::none;
    const FormFamily& family = heights.family();
    const auto& vertices = mesh.vertices();
    const auto& edges = mesh.edges();
    const auto& half_edges = mesh.half_edges();
    MinimizationDiagram out;
    out.forms = family.forms;
    out.cylinders = family.cylinders;
    out.radial = family.radial;

    std::vector<Index> vertex_map(vertices.size(), none), edge_map(edges.size(), none),
        face_map(mesh.face_count() + 2, none);
    const auto alive_edges = static_cast<std::size_t>(std::ranges::count_if(edges, &FormMesh::Edge::alive));
    const auto alive_vertices =
        static_cast<std::size_t>(std::ranges::count_if(vertices, &FormMesh::Vertex::alive));
    out.dcel.reserve(alive_vertices, alive_edges, mesh.face_count() + 1);
    out.vertices.reserve(alive_vertices);
    out.edges.reserve(alive_edges);
    out.face_forms.push_back({});
    for (Index v = 0; v < vertices.size(); ++v) {
        if (!vertices[v].alive) continue;
        vertex_map[v] = out.dcel.add_vertex().value;
        const FormMesh::Vertex& from = vertices[v];
        double size = from.height, off = from.height_error;
        if (from.lowest.valid()) {
            const Interval height = height_at(heights, from, from.lowest);
            size = height.mid();
            off = height.radius();
        }
        out.vertices.push_back({{from.x, from.y}, from.error, size, off});
    }
    for (Index e = 0; e < edges.size(); ++e) {
        if (!edges[e].alive) continue;
        const Index from = half_edges[2 * e].origin, to = half_edges[2 * e + 1].origin;
        edge_map[e] = out.dcel
                          .add_edge(from == none ? VertexId{} : VertexId{vertex_map[from]},
                                    to == none ? VertexId{} : VertexId{vertex_map[to]})
                          .value;
        out.edges.push_back({edges[e].left, edges[e].right, edges[e].side});
        if (family.is_all_circular()) continue;
        out.piece_offsets_.push_back(static_cast<std::uint32_t>(out.pieces_.size()));
        for (const FormMesh::Link& l : mesh.links(e))
            out.pieces_.push_back({l.to, l.to_error, l.direction, l.box});
    }
    if (!family.is_all_circular())
        out.piece_offsets_.push_back(static_cast<std::uint32_t>(out.pieces_.size()));
    const auto half_edge = [&](Index h) { return HalfEdgeId{2 * edge_map[h >> 1] | (h & 1u)}; };
    for (Index h = 0; h < half_edges.size(); ++h)
        if (edges[h >> 1].alive) out.dcel.link(half_edge(h), half_edge(half_edges[h].next));

    // Faces outside the region are numbered after the others: the unbounded one, and beyond a cylinder's
    // upper rim.
    const auto inside = static_cast<Index>(mesh.face_count());
    const Index root = outside.pole_face == none ? inside : mesh.united(outside.pole_face);
    const auto face_of = [&](Index h) {
        if (half_edges[h].face != none) return mesh.united(half_edges[h].face);
        return edges[h >> 1].side == outside.upper_rim ? inside + 1 : inside;
    };
    Components components(inside + 2);
    std::vector<Index> component_of(half_edges.size(), none);
    for (Index h = 0; h < half_edges.size(); ++h) {
        if (!edges[h >> 1].alive || component_of[h] != none) continue;
        const Index c = components.add(h, face_of(h));
        for (Index g = h; component_of[g] == none; g = half_edges[g].next) component_of[g] = c;
    }
    if (components.is_nested(root)) {
        for (Index h = 0; h < half_edges.size(); h += 2)
            if (component_of[h] != none) components.join(component_of[h], component_of[h + 1]);
        components.find_outer(root);
    }
    const auto add_inner = [&](FaceId f, Index c) {
        out.dcel.add_inner_ccb(f, half_edge(components.start(c)));
    };
    for (Index c = components.first(root); c != none; c = components.next(c))
        add_inner(Dcel::unbounded_face(), c);
    if (root != inside) out.face_forms[Dcel::unbounded_face()] = mesh.site(root);
    face_map[root] = Dcel::unbounded_face().value;
    const auto add_face = [&](Index f, FormId form) {
        if (f == root || components.first(f) == none) return;
        const FaceId id = out.dcel.add_face();
        face_map[f] = id.value;
        out.face_forms.push_back(form);
        const Index outer = components.outer(f);
        if (outer == none) throw InternalError("glued pieces: a face hangs together with no other");
        out.dcel.add_outer_ccb(id, half_edge(components.start(outer)));
        for (Index c = components.first(f); c != none; c = components.next(c))
            if (c != outer) add_inner(id, c);
    };
    add_face(inside + 1, {});
    for (Index f = 0; f < inside; ++f) add_face(f, mesh.site(f));
    for (const Index v : mesh.isolated())
        if (vertices[v].alive)
            out.dcel.add_isolated_vertex(FaceId{face_map[mesh.united(vertices[v].isolated_in)]},
                                         VertexId{vertex_map[v]});

    // Labels: the faces around, and whatever else ties.
    std::vector<FormId> label;
    std::vector<std::uint32_t> sides;
    out.vertex_offsets_.push_back(0);
    out.side_offsets_.push_back(0);
    for (Index v = 0; v < vertices.size(); ++v) {
        if (!vertices[v].alive) continue;
        label.clear();
        sides.clear();
        if (vertices[v].out != none)
            mesh.for_leaving(vertices[v].out, [&](Index h) {
                if (mesh.left_of(h).valid()) label.push_back(mesh.left_of(h));
                if (edges[h >> 1].side != UINT32_MAX) sides.push_back(edges[h >> 1].side);
            });
        if (vertices[v].lowest.valid())
            tell_height(heights, vertices[v], label, out.vertices[VertexId{vertex_map[v]}]);
        if (vertices[v].ties != none) {
            const auto& ties = mesh.ties(vertices[v].ties);
            label.insert(label.end(), ties.begin(), ties.end());
        }
        sort_unique(label);
        sort_unique(sides);
        out.vertex_labels_.insert(out.vertex_labels_.end(), label.begin(), label.end());
        out.vertex_sides_.insert(out.vertex_sides_.end(), sides.begin(), sides.end());
        out.vertex_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_labels_.size()));
        out.side_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_sides_.size()));
    }
    out.edge_offsets_.push_back(0);
    for (Index e = 0; e < edges.size(); ++e) {
        if (!edges[e].alive) continue;
        const auto [left, right] = std::pair(edges[e].left, edges[e].right);
        if (edges[e].ties != none || !left.valid() || !right.valid()) {
            label = mesh.label_of_edge(e);
            out.edge_labels_.insert(out.edge_labels_.end(), label.begin(), label.end());
        } else {
            out.edge_labels_.push_back(std::min(left, right));
            if (left != right) out.edge_labels_.push_back(std::max(left, right));
        }
        out.edge_offsets_.push_back(static_cast<std::uint32_t>(out.edge_labels_.size()));
    }
    return out;
}

}  // namespace vcell
