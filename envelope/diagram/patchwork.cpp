#include "patchwork.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "../../core/errors.hpp"
#include "../../core/sort_unique.hpp"
#include "frozen_mesh.hpp"

namespace vcell {

Patchwork::Patchwork(const FormFamily& family, std::size_t forms) : family_(family) { reserve(forms); }

MinimizationDiagram Patchwork::finish(const Heights& heights) {
    require_soundness();
    return frozen(*this, {upper_rim_, pole_face_}, heights);
}

Patchwork::Index Patchwork::add(const WorkDiagram& piece, std::span<const PieceSide> line_sides) {
    const CircleKernel& kernel = piece.kernel();
    const auto copy_ties = [&](Index list) {
        if (list == none) return none;
        std::vector<FormId> forms;
        for (const FormId f : piece.ties()[list]) forms.push_back(kernel.family_id(f));
        return add_ties(std::move(forms));
    };

    // Faces first: their numbers shift by a constant once the dead ones are skipped.
    std::vector<Index>& face_map = face_map_;
    face_map.assign(piece.faces().size(), none);
    for (Index f = 1; f < piece.faces().size(); ++f) {
        if (!piece.faces()[f].alive) continue;
        face_map[f] = add_face(kernel.family_id(piece.faces()[f].site));
    }
    std::vector<Index>& vertex_map = vertex_map_;
    vertex_map.assign(piece.vertices().size(), none);
    for (Index v = 0; v < piece.vertices().size(); ++v) {
        const WorkDiagram::Vertex& from = piece.vertices()[v];
        if (!from.alive) continue;
        const KernelPoint& p = kernel.point(from.point);
        vertex_map[v] = static_cast<Index>(vertices_.size());
        Vertex& to = vertices_.emplace_back();
        to.x = p.x;
        to.y = p.y;
        to.error = p.error;
        to.ties = copy_ties(from.ties);
        // Some face at the vertex: its form attains the minimum here.
        Index face = from.isolated_in;
        if (from.out != none) {
            Index h = from.out;
            while (piece.half_edges()[h].face == WorkDiagram::outside) h = piece.half_edges()[h].prev ^ 1u;
            face = piece.half_edges()[h].face;
        } else {
            to.isolated_in = face_map[face];
            isolated_.push_back(vertex_map[v]);
        }
        const auto [height, height_error] = kernel.height(piece.faces()[face].site, from.point);
        to.height = height;
        to.height_error = height_error;
    }
    std::vector<Index>& edge_map = edge_map_;
    edge_map.assign(piece.edges().size(), none);
    Index count = static_cast<Index>(edges_.size());
    for (Index e = 0; e < piece.edges().size(); ++e)
        if (piece.edges()[e].alive) edge_map[e] = count++;
    const auto map_half_edge = [&](Index h) { return 2 * edge_map[h >> 1] | (h & 1u); };
    Index handle = none;
    for (Index e = 0; e < piece.edges().size(); ++e) {
        const WorkDiagram::Edge& from = piece.edges()[e];
        if (!from.alive) continue;
        Edge& to = edges_.emplace_back();
        to.left = kernel.family_id(piece.half_edges()[2 * e].label);
        if (from.rim)
            to.side = line_sides[from.curve.g.value - 1].id;
        else
            to.right = kernel.family_id(piece.half_edges()[2 * e + 1].label);
        to.ties = copy_ties(from.ties);
        for (const Index h : {2 * e, 2 * e + 1}) {
            const WorkDiagram::HalfEdge& half = piece.half_edges()[h];
            const Index origin = half.origin == none ? none : vertex_map[half.origin];
            half_edges_.push_back(
                {map_half_edge(half.next), map_half_edge(half.prev), origin, face_map[half.face]});
            if (origin != none) vertices_[origin].out = map_half_edge(h);
            if (half.face == WorkDiagram::outside) handle = map_half_edge(h);
        }
    }
    return handle;
}

// Around a vertex, counter-clockwise, its outgoing half-edges follow each other as the piece lists them; each
// one's twin turns into the one before.
Patchwork::Index Patchwork::add(const MixedPiece& piece) {
    const auto first_vertex = static_cast<Index>(vertices_.size());
    const auto first_edge = static_cast<Index>(edges_.size());
    const auto rim = static_cast<Index>(piece.rim.size());
    for (const MixedPiece::Vertex& from : piece.vertices) {
        Vertex& to = vertices_.emplace_back();
        to.x = from.point.x();
        to.y = from.point.y();
        to.error = from.error;
        to.lowest = from.lowest;
        if (!from.ties.empty()) to.ties = add_ties(from.ties);
    }
    for (Index i = 0; i < rim; ++i) {
        Edge& e = edges_.emplace_back();
        e.left = piece.rim[i].label;
        e.side = piece.rim[i].side;
        const Index next = (i + 1) % rim;
        half_edges_.push_back({none, none, first_vertex + i, none});
        half_edges_.push_back({none, none, first_vertex + next, none});
    }
    for (const MixedPiece::Arc& a : piece.arcs) {
        Edge& e = edges_.emplace_back();
        e.left = a.left;
        e.right = a.right;
        if (!family_.is_circular(a.left) || !family_.is_circular(a.right)) {
            const MixedPiece::Vertex &p = piece.vertices[a.from], &q = piece.vertices[a.to];
            e.links = static_cast<Index>(links_.size());
            std::vector<Link>& links = links_.emplace_back();
            for (const auto& s : a.pieces) {
                const Link before = links.empty() ? Link{{}, p.point, 0, p.error, {}, {}} : links.back();
                links.push_back({before.to, s.end, before.to_error, s.error, s.direction, s.box});
            }
            if (links.empty()) links.push_back({p.point, q.point, p.error, q.error, a.direction, piece.box});
        }
        half_edges_.push_back({none, none, first_vertex + a.from, none});
        half_edges_.push_back({none, none, first_vertex + a.to, none});
    }
    std::vector<Index>& out = around_;
    for (Index v = 0; v < piece.vertices.size(); ++v) {
        out.clear();
        if (v < rim) out.push_back(2 * (first_edge + v));
        for (const std::uint32_t h : piece.leaving[v]) out.push_back(2 * (first_edge + rim) + h);
        if (v < rim) out.push_back(2 * (first_edge + (v + rim - 1) % rim) + 1);
        if (out.empty()) continue;
        vertices_[first_vertex + v].out = out.front();
        for (std::size_t k = 0; k < out.size(); ++k)
            link(twin(out[k]), out[(k + out.size() - 1) % out.size()]);
    }
    std::size_t orbits = 1;  // with the one outside
    for (Index h = 2 * first_edge; h < half_edges_.size(); ++h) {
        const bool outside = h < 2 * (first_edge + rim) && (h & 1u);
        if (outside || half_edges_[h].face != none) continue;
        const Index f = add_face(left_of(h));
        ++orbits;
        for (Index g = h; half_edges_[g].face == none; g = half_edges_[g].next) {
            if (left_of(g) != site(f)) throw InternalError("labels differ around a face of a piece");
            half_edges_[g].face = f;
        }
    }
    // Euler's formula tells whether all arcs hang together.
    const auto corners = static_cast<std::size_t>(std::ranges::count_if(
        std::span(vertices_).subspan(first_vertex), [](const Vertex& v) { return v.out != none; }));
    if (corners + orbits != 2 + (edges_.size() - first_edge)) join_island(first_edge);
    // A vertex without edges is one of a piece without arcs.
    for (Index v = rim; v < piece.vertices.size(); ++v) {
        if (!piece.leaving[v].empty()) continue;
        vertices_[first_vertex + v].isolated_in = static_cast<Index>(face_count() - 1);
        isolated_.push_back(first_vertex + v);
    }
    return 2 * first_edge + 1;
}

// Arcs that hang together with nothing of the rim are an island, which one of its orbits surrounds: that has
// the label of the face that it lies in. Where one orbit and one face alone have a label in common, these are
// they.
void Patchwork::join_island(Index first_edge) {
    const Index first = 2 * first_edge;
    std::vector<char> part(half_edges_.size() - first, 0);
    std::vector<Index> open;
    const auto flood = [&](Index from, char number) {
        open.push_back(from);
        while (!open.empty()) {
            const Index h = open.back();
            open.pop_back();
            if (std::exchange(part[h - first], number) == number) continue;
            open.push_back(half_edges_[h].next);
            open.push_back(twin(h));
        }
    };
    flood(first, 1);
    const auto of_island = std::ranges::find(part, char{0});
    if (of_island == part.end()) throw InternalError("a piece's arcs do not fit together");
    flood(first + static_cast<Index>(of_island - part.begin()), 2);
    std::vector<Index> around, inside;
    for (Index h = first; h < half_edges_.size(); ++h)
        if (half_edges_[h].face != none)
            (part[h - first] == 2 ? inside : around).push_back(half_edges_[h].face);
    sort_unique(around);
    sort_unique(inside);
    std::vector<std::pair<Index, Index>> pairs;
    for (const Index f : around)
        for (const Index g : inside)
            if (site(f) == site(g)) pairs.emplace_back(f, g);
    if (pairs.size() != 1 || std::ranges::find(part, char{0}) != part.end())
        throw UndecidedError("islands in a piece: which face they lie in is not told by labels");
    merge_faces(pairs.front().first, pairs.front().second);
}

// The half-edges along the seam, in their order on the outer boundary.
Patchwork::Chain Patchwork::side_chain(Index outer, std::uint32_t seam) const {
    const auto on_seam = [&](Index h) { return edges_[h >> 1].side == seam; };
    Index h = outer;
    while (on_seam(h)) h = half_edges_[h].prev;
    const Index stop = h;
    do {
        h = half_edges_[h].next;
        if (h == stop) throw InternalError("a piece does not reach its seam");
    } while (!on_seam(h));
    Chain chain;
    for (; on_seam(h); h = half_edges_[h].next) chain.push_back(h);
    return chain;
}

// Turn the seam upright, the first piece on its left. On the outside the first piece's chain runs down,
// the second's up. At a vertex of the seam let a_1, ..., a_p be the first piece's half-edges that leave it,
// counter-clockwise from the seam's upper half, and b_1, ..., b_q the second's from the lower half. Their
// rotation in the union is a_1 .. a_p b_1 .. b_q: only the turns a_p -> b_1 and b_q -> a_1 are new.
Patchwork::Index Patchwork::glue(Index piece, Index other, std::uint32_t seam) {
    return join_chains(side_chain(piece, seam), side_chain(other, seam));
}

// The same around the cylinder: the piece lies on both sides of the seam.
void Patchwork::close(Index piece, std::uint32_t right, std::uint32_t left, double circumference,
                      std::uint32_t upper) {
    upper_rim_ = upper;
    const Chain down = side_chain(piece, right), up = side_chain(piece, left);
    for (const Index h : down) vertices_[half_edges_[h].origin].x -= circumference;
    vertices_[target(down.back())].x -= circumference;
    join_chains(down, up);
}

Patchwork::Index Patchwork::join_chains(const Chain& down, const Chain& up) {
    const std::size_t k = down.size();
    if (up.size() != k)
        throw InternalError("a seam has " + std::to_string(k) + " edges on one side and " +
                            std::to_string(up.size()) + " on the other");
    const auto first = [&](std::size_t j) { return twin(down[j]); };         // runs up on the left
    const auto second = [&](std::size_t j) { return twin(up[k - 1 - j]); };  // runs down on the right
    for (std::size_t j = 0; j < k; ++j) merge_faces(half_edges_[first(j)].face, half_edges_[second(j)].face);

    const Index top_before = half_edges_[down[0]].prev, top_after = half_edges_[up[k - 1]].next;
    const Index bottom_before = half_edges_[up[0]].prev, bottom_after = half_edges_[down[k - 1]].next;
    struct Junction {
        Index kept, other, outgoing, face;
    };
    SmallVector<Junction, usual_chain + 1> junctions;
    junctions.reserve(k + 1);
    for (std::size_t j = 0; j <= k; ++j) {
        Junction v{j < k ? half_edges_[down[j]].origin : target(down[k - 1]),
                   j < k ? target(up[k - 1 - j]) : half_edges_[up[0]].origin, none,
                   half_edges_[first(j < k ? j : k - 1)].face};
        // Below: the first piece's last half-edge a_p, and the one that arrives along b_1; above: b_q, a_1.
        const Index a_last = j < k ? half_edges_[first(j)].next : none;
        const Index b_first = j < k ? half_edges_[second(j)].prev : none;
        const Index a_first = j > 0 ? half_edges_[first(j - 1)].prev : none;
        const Index b_last = j > 0 ? half_edges_[second(j - 1)].next : none;
        const bool no_a = j > 0 && j < k && a_last == first(j - 1),
                   no_b = j > 0 && j < k && b_last == second(j);
        if (j == 0) {
            link(b_first, a_last);
            v.outgoing = a_last;
        } else if (j == k) {
            link(a_first, b_last);
            v.outgoing = b_last;
        } else if (no_a && !no_b) {
            link(b_first, b_last);
            v.outgoing = b_last;
        } else if (no_b && !no_a) {
            link(a_first, a_last);
            v.outgoing = a_last;
        } else if (!no_a) {
            link(b_first, a_last);
            link(a_first, b_last);
            v.outgoing = a_last;
        }
        junctions.push_back(v);
    }
    link(top_before, top_after);
    link(bottom_before, bottom_after);
    for (std::size_t j = 0; j < k; ++j) edges_[down[j] >> 1].alive = edges_[up[j] >> 1].alive = false;
    for (const Junction& v : junctions) unite_vertices(v.kept, v.other, v.outgoing, v.face);
    for (const Junction& v : junctions) smooth(v.kept);
    for (const Index h : {top_before, top_after, bottom_before, bottom_after})
        if (edges_[h >> 1].alive) return h;
    throw InternalError("a glued piece has no outer edge");
}

void Patchwork::unite_vertices(Index kept, Index other, Index outgoing, Index face) {
    vertices_[other].alive = false;
    Vertex& v = vertices_[kept];
    v.out = outgoing;
    if (vertices_[other].ties != none) {
        if (v.ties == none) {
            v.ties = vertices_[other].ties;
        } else {
            std::vector<FormId>& forms = ties_[v.ties];
            forms.insert(forms.end(), ties_[vertices_[other].ties].begin(),
                         ties_[vertices_[other].ties].end());
            sort_unique(forms);
        }
    }
    if (outgoing == none) {
        // Nothing crosses or touches the seam here but, perhaps, a form that ties at this one point.
        if (v.ties == none || ties_[v.ties].size() < 2) {
            v.alive = false;
        } else {
            v.isolated_in = face;
            isolated_.push_back(kept);
        }
        return;
    }
    for_leaving(outgoing, [&](Index h) { half_edges_[h].origin = kept; });
}

void Patchwork::tie_along_rim(const AreOne& are_one) {
    std::vector<Index> ends;
    for (Index e = 0; e < edges_.size(); ++e) {
        const Index from = half_edges_[2 * e].origin, to = target(2 * e);
        if (!edges_[e].alive || edges_[e].side == none || from == none || to == none) continue;
        ends.push_back(from);
        const auto place = [&](Index v) { return Eigen::Vector2d(vertices_[v].x, vertices_[v].y); };
        const std::vector<FormId> at_end = label_of_origin(2 * e + 1);
        std::vector<FormId> label = label_of_edge(e);
        const std::size_t known = label.size();
        for (const FormId g : label_of_origin(2 * e))
            if (std::ranges::binary_search(at_end, g) && std::ranges::find(label, g) == label.end() &&
                are_one(edges_[e].side, place(from), place(to), edges_[e].left, g))
                label.push_back(g);
        if (label.size() > known) edges_[e].ties = add_ties(std::move(label));
    }
    for (const Index v : ends) smooth(v);
}

void Patchwork::drop_rim(Index outer) {
    pole_face_ = half_edges_[twin(outer)].face;
    for_cycle(outer, [&](Index h) {
        edges_[h >> 1].alive = false;
        vertices_[half_edges_[h].origin].alive = false;
    });
}

}  // namespace vcell
