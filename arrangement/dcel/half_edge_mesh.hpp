/// The links of a subdivision that changes in place: half-edges 2e and 2e + 1 are the twins of edge e, each
/// with its face on its left. Every diagram under construction is one; what is finished is a Dcel.
///
/// Which elements there are, and what else is known of them, is the diagram's: `HalfEdge` has at least the
/// members Index next, prev, origin, face. A closed edge without vertices is its own next and has no origin.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../../core/partition.hpp"

namespace vcell {

template <class HalfEdge>
class HalfEdgeMesh {
public:
    using Index = std::uint32_t;
    static constexpr Index none = UINT32_MAX;

    static Index twin(Index h) { return h ^ 1u; }
    Index target(Index h) const { return half_edges_[twin(h)].origin; }
    const std::vector<HalfEdge>& half_edges() const { return half_edges_; }
    Index next(Index h) const { return half_edges_[h].next; }
    Index prev(Index h) const { return half_edges_[h].prev; }
    /// The next half-edge that leaves the same vertex, counter-clockwise.
    Index next_around_origin(Index h) const { return twin(prev(h)); }

    /// visit(h) for the cycle of `start`; it may take out the edge of h.
    template <class Visit>
    void for_cycle(Index start, Visit&& visit) const {
        Index h = start;
        do {
            const Index after = next(h);
            visit(h);
            h = after;
        } while (h != start);
    }
    /// visit(h) for what leaves the vertex of `start`, counter-clockwise.
    template <class Visit>
    void for_leaving(Index start, Visit&& visit) const {
        Index h = start;
        do {
            visit(h);
            h = next_around_origin(h);
        } while (h != start);
    }

protected:
    void link(Index first, Index second) {
        half_edges_[first].next = second;
        half_edges_[second].prev = first;
    }

    /// h ends in vertex v, and n goes on from there in its place; copies what else h and its twin are. Pre: n
    /// and its twin are not linked; h and its twin do not follow each other.
    void split(Index h, Index v, Index n) {
        const Index t = twin(h), m = twin(n), after = next(h), before = prev(t);
        half_edges_[n] = half_edges_[h];
        half_edges_[m] = half_edges_[t];
        half_edges_[n].origin = half_edges_[t].origin = v;
        link(n, after);
        link(h, n);
        link(before, m);
        link(m, t);
    }
    /// h runs on over its successor n, whose edge comes out, and so does the vertex between them. Pre: these
    /// two are the vertex's only edges, and not one.
    void join(Index h) {
        const Index n = next(h), t = twin(h), m = twin(n);
        half_edges_[t].origin = half_edges_[m].origin;
        link(h, next(n));
        link(prev(m), t);
    }
    /// Takes half-edge h out of the rotation about its origin; returns another that leaves it, or none.
    Index detach(Index h) {
        const Index before = prev(h), after = next(twin(h));
        if (after == h) return none;
        link(before, after);
        return after;
    }

    /// The first broken invariant, in words that name the elements: next and prev, origins, one face along
    /// each cycle, one rotation about each vertex, and V - E + cycles = 2 for each connected part.
    /// is_alive(e) tells which edges there are.
    template <class IsAlive>
    std::optional<std::string> find_defect(IsAlive&& is_alive) const;

    std::vector<HalfEdge> half_edges_;
};

template <class HalfEdge>
template <class IsAlive>
std::optional<std::string> HalfEdgeMesh<HalfEdge>::find_defect(IsAlive&& is_alive) const {
    const auto name = [](Index h) { return "h" + std::to_string(h); };
    const auto count = static_cast<Index>(half_edges_.size());
    const auto alive = [&](Index h) { return h < count && is_alive(h >> 1); };
    std::vector<int> degree;  // of vertices: half-edges that leave them
    for (Index h = 0; h < count; ++h) {
        if (!alive(h)) continue;
        const HalfEdge& x = half_edges_[h];
        if (!alive(x.next)) return name(h) + " has no next";
        if (!alive(x.prev)) return name(h) + " has no prev";
        if (next(x.prev) != h) return name(h) + " is not the next of its prev " + name(x.prev);
        if (prev(x.next) != h) return name(h) + " is not the prev of its next " + name(x.next);
        if (half_edges_[x.next].origin != target(h)) return name(h) + " does not end where its next begins";
        if (half_edges_[x.next].face != x.face) return name(h) + " has another face than its next";
        if ((x.origin == none) != (target(h) == none)) return name(h) + " has only one end";
        if (x.origin == none) {
            if (x.next != h) return name(h) + " has no vertices but is not its own next";
            continue;
        }
        if (x.origin >= degree.size()) degree.resize(x.origin + 1, 0);
        ++degree[x.origin];
    }
    // Nodes: vertices, and after them closed edges.
    const auto vertices = static_cast<Index>(degree.size());
    Partition parts(vertices + count / 2);
    const auto node = [&](Index h) {
        return half_edges_[h].origin == none ? vertices + h / 2 : half_edges_[h].origin;
    };
    for (Index h = 0; h < count; h += 2)
        if (alive(h)) parts.merge(node(h), node(twin(h)));
    std::vector<int> euler(vertices + count / 2, 0);
    std::vector<char> is_on_cycle(count, 0);
    for (Index h = 0; h < count; ++h) {
        if (!alive(h)) continue;
        int& sum = euler[parts.find(node(h))];
        if (const Index v = half_edges_[h].origin; v != none) {
            if (h % 2 == 0) --sum;
            if (degree[v] > 0) {
                ++sum;
                for_leaving(h, [&](Index) { --degree[v]; });
                if (degree[v] != 0)
                    return "the rotation from " + name(h) + " does not meet all that leave its origin";
            }
        }
        if (is_on_cycle[h]) continue;
        ++sum;
        for_cycle(h, [&](Index g) { is_on_cycle[g] = 1; });
    }
    for (Index h = 0; h < count; ++h)
        if (alive(h) && euler[parts.find(node(h))] != 2)
            return "the part of " + name(h) +
                   " has V - E + cycles = " + std::to_string(euler[parts.find(node(h))]) +
                   ", not 2: it is not planar";
    return std::nullopt;
}

}  // namespace vcell
