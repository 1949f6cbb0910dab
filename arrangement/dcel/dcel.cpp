#include "dcel.hpp"

#include <cassert>

#include "../../core/partition.hpp"

namespace vcell {

Dcel::Dcel() { faces_.push_back({}); }

void Dcel::reserve(std::size_t vertices, std::size_t edges, std::size_t faces) {
    vertices_.reserve(vertices);
    half_edges_.reserve(2 * edges);
    ccbs_.reserve(faces);
    faces_.reserve(faces);
}

VertexId Dcel::add_vertex() { return vertices_.push_back({}); }

EdgeId Dcel::add_edge(VertexId from, VertexId to) {
    assert(from.valid() == to.valid());
    const HalfEdgeId h = half_edges_.push_back({{}, {}, from, {}});
    const HalfEdgeId t = half_edges_.push_back({{}, {}, to, {}});
    if (!from.valid()) {
        link(h, h);
        link(t, t);
        return edge(h);
    }
    if (!vertices_[from].outgoing.valid()) vertices_[from].outgoing = h;
    if (!vertices_[to].outgoing.valid()) vertices_[to].outgoing = t;
    return edge(h);
}

FaceId Dcel::add_face() { return faces_.push_back({}); }

CcbId Dcel::add_ccb(FaceId f, HalfEdgeId start, bool outer) {
    const CcbId c = ccbs_.push_back({f, start, outer});
    if (outer) {
        faces_[f].outer = c;
    } else {
        faces_[f].inner.push_back(c);
    }
    HalfEdgeId h = start;
    do {
        half_edges_[h].ccb = c;
        h = next(h);
    } while (h != start);
    return c;
}

void Dcel::add_isolated_vertex(FaceId f, VertexId v) {
    vertices_[v].isolated_in = f;
    faces_[f].isolated.push_back(v);
}

namespace {

std::optional<DcelDefect> defect(std::string what) { return DcelDefect{std::move(what)}; }

}  // namespace

std::optional<DcelDefect> Dcel::find_defect() const {
    const auto in = [](auto id, const auto& elements) { return id.value < elements.size(); };

    // References and links. From here on every id can be followed.
    for (const HalfEdgeId h : half_edges_.ids()) {
        const HalfEdge& x = half_edges_[h];
        if (!in(x.next, half_edges_)) return defect(to_string(h) + " has no next");
        if (!in(x.prev, half_edges_)) return defect(to_string(h) + " has no prev");
        if (!in(x.ccb, ccbs_)) return defect(to_string(h) + " belongs to no component");
        if (x.origin.valid() && !in(x.origin, vertices_))
            return defect(to_string(h) + ": its origin does not exist");
        if (x.origin.valid() != target(h).valid()) return defect(to_string(h) + " has only one end");
    }
    for (const HalfEdgeId h : half_edges_.ids()) {
        if (prev(next(h)) != h)
            return defect(to_string(h) + " is not the prev of its next " + to_string(next(h)));
        if (next(prev(h)) != h)
            return defect(to_string(h) + " is not the next of its prev " + to_string(prev(h)));
        if (!origin(h).valid() && next(h) != h)
            return defect(to_string(h) + " has no vertices but is not its own next");
        if (origin(next(h)) != target(h)) {
            return defect(to_string(h) + " ends at " + to_string(target(h)) + " but its next " +
                          to_string(next(h)) + " starts at " + to_string(origin(next(h))));
        }
    }

    // Components: each is one whole cycle and hangs in exactly one face.
    IdVector<HalfEdgeId, char> on_cycle(half_edges_.size(), 0);
    for (const CcbId c : ccbs_.ids()) {
        if (!in(ccbs_[c].face, faces_)) return defect(to_string(c) + " belongs to no face");
        if (!in(start(c), half_edges_)) return defect(to_string(c) + " has no start");
        HalfEdgeId h = start(c);
        do {
            if (ccb(h) != c)
                return defect(to_string(h) + " lies on the cycle of " + to_string(c) + " but names " +
                              to_string(ccb(h)));
            on_cycle[h] = 1;
            h = next(h);
        } while (h != start(c));
    }
    for (const HalfEdgeId h : half_edges_.ids()) {
        if (!on_cycle[h])
            return defect(to_string(h) + " is not on the cycle of its component " + to_string(ccb(h)));
    }
    IdVector<CcbId, int> listed(ccbs_.size(), 0);
    for (const FaceId f : faces_.ids()) {
        const Face& x = faces_[f];
        if (x.outer.valid() == (f == unbounded_face())) {
            return defect(to_string(f) + (x.outer.valid() ? " is unbounded but has an outer component"
                                                          : " has no outer component"));
        }
        if (x.outer.valid()) {
            if (!in(x.outer, ccbs_) || !is_outer(x.outer) || face(x.outer) != f)
                return defect(to_string(f) + ": its outer component does not name it");
            ++listed[x.outer];
        }
        for (const CcbId c : x.inner) {
            if (!in(c, ccbs_) || is_outer(c) || face(c) != f)
                return defect(to_string(f) + ": its inner component " + to_string(c) + " does not name it");
            ++listed[c];
        }
    }
    for (const CcbId c : ccbs_.ids()) {
        if (listed[c] != 1)
            return defect(to_string(c) + " is listed " + std::to_string(listed[c]) + " times by its face");
    }

    // Vertices: one rotation holds all half-edges that leave a vertex; none means isolated, once.
    IdVector<VertexId, std::uint32_t> degree(vertices_.size(), 0);
    for (const HalfEdgeId h : half_edges_.ids()) {
        if (origin(h).valid()) ++degree[origin(h)];
    }
    IdVector<VertexId, std::uint32_t> isolated(vertices_.size(), 0);
    for (const FaceId f : faces_.ids()) {
        for (const VertexId v : faces_[f].isolated) {
            if (!in(v, vertices_) || isolated_in(v) != f)
                return defect(to_string(f) + " lists isolated " + to_string(v) + ", which does not name it");
            ++isolated[v];
        }
    }
    for (const VertexId v : vertices_.ids()) {
        const HalfEdgeId first = outgoing(v);
        if (isolated[v] != (degree[v] == 0 ? 1u : 0u))
            return defect(to_string(v) + " has degree " + std::to_string(degree[v]) +
                          " and is listed as isolated " + std::to_string(isolated[v]) + " times");
        if (isolated_in(v).valid() != (degree[v] == 0))
            return defect(to_string(v) + " has edges but names a face that holds it");
        if (first.valid() != (degree[v] != 0))
            return defect(to_string(v) + " has no outgoing half-edge of its own");
        if (!first.valid()) continue;
        if (!in(first, half_edges_) || origin(first) != v)
            return defect(to_string(v) + ": its outgoing " + to_string(first) + " starts elsewhere");
        std::uint32_t turned = 0;
        HalfEdgeId h = first;
        do {
            ++turned;
            h = next_around_origin(h);
        } while (h != first && turned <= degree[v]);
        if (turned != degree[v])
            return defect(to_string(v) + ": the rotation from " + to_string(first) +
                          " does not meet all its half-edges");
    }

    // Connected components of the graph. A closed edge counts as if it had one vertex, which makes it
    // a component of its own; its node follows those of the vertices.
    const std::size_t vertex_count = vertices_.size();
    Partition parts(vertex_count + edge_count());
    const auto node = [&](HalfEdgeId h) {
        return origin(h).valid() ? origin(h).value : static_cast<std::uint32_t>(vertex_count + edge(h).value);
    };
    std::size_t closed = 0;
    for (std::uint32_t e = 0; e < edge_count(); ++e) {
        const HalfEdgeId h = half_edge(EdgeId{e});
        if (origin(h).valid()) {
            parts.merge(origin(h).value, target(h).value);
        } else {
            ++closed;
        }
    }
    std::vector<long> euler(vertex_count + edge_count(), 0);  // V - E + cycles of each component, at its root
    std::vector<CcbId> outside(vertex_count + edge_count());  // its one inner component
    for (std::uint32_t v = 0; v < vertex_count; ++v) ++euler[parts.find(v)];
    for (std::uint32_t e = 0; e < edge_count(); ++e) {
        const HalfEdgeId h = half_edge(EdgeId{e});
        if (origin(h).valid()) --euler[parts.find(node(h))];
    }
    for (const CcbId c : ccbs_.ids()) {
        const std::uint32_t root = parts.find(node(start(c)));
        ++euler[root];
        if (is_outer(c)) continue;
        if (outside[root].valid())
            return defect(to_string(c) + " and " + to_string(outside[root]) +
                          " are both the outside of one connected component");
        outside[root] = c;
    }
    // In the plane every connected component is seen from outside by one inner CCB, and has genus 0.
    std::size_t components = 0;
    for (std::uint32_t n = 0; n < euler.size(); ++n) {
        const bool closed_edge = n >= vertex_count;
        if (closed_edge && origin(half_edge(EdgeId{static_cast<std::uint32_t>(n - vertex_count)})).valid())
            continue;
        if (parts.find(n) != n) continue;
        ++components;
        if (!closed_edge && degree[VertexId{n}] == 0) continue;
        const std::string title =
            closed_edge ? "closed " + to_string(EdgeId{static_cast<std::uint32_t>(n - vertex_count)})
                        : "the component of " + to_string(VertexId{n});
        if (!outside[n].valid()) return defect(title + " has no inner component around it");
        if (euler[n] != 2)
            return defect(title + " has V - E + cycles = " + std::to_string(euler[n]) +
                          ", not 2: it is not planar");
    }
    if (vertex_count + closed + faces_.size() != edge_count() + 1 + components) {
        return defect("V - E + F = " +
                      std::to_string(static_cast<long>(vertex_count + closed + faces_.size()) -
                                     static_cast<long>(edge_count())) +
                      " but 1 + C = " + std::to_string(1 + components));
    }

    // Nesting: from any face the way outwards, through the component that bounds it, ends in the
    // unbounded face. A face is known to be good once a walk from it has been.
    IdVector<FaceId, std::uint32_t> walked(faces_.size(), 0);  // number of the walk that came by
    for (const FaceId f : faces_.ids()) {
        FaceId g = f;
        while (g != unbounded_face() && walked[g] == 0) {
            walked[g] = f.value + 1;
            g = face(outside[parts.find(node(start(outer_ccb(g))))]);
        }
        if (g != unbounded_face() && walked[g] == f.value + 1)
            return defect(to_string(g) + " lies inside itself");
    }
    return std::nullopt;
}

}  // namespace vcell
