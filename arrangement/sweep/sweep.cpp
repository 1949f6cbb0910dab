#include "sweep.hpp"

namespace vcell {

IndexLists IndexLists::by_key(std::span<const std::uint32_t> key, std::size_t count) {
    IndexLists lists;
    lists.offsets_.assign(count + 1, 0);
    for (const std::uint32_t k : key) ++lists.offsets_[k + 1];
    std::partial_sum(lists.offsets_.begin(), lists.offsets_.end(), lists.offsets_.begin());
    lists.items_.resize(key.size());
    std::vector<std::uint32_t> place(lists.offsets_.begin(), lists.offsets_.end() - 1);
    for (std::uint32_t i = 0; i < key.size(); ++i) lists.items_[place[key[i]]++] = i;
    return lists;
}

namespace detail {

PairSet::PairSet(std::size_t expected) {
    std::size_t capacity = 64;
    while (capacity < 2 * expected) capacity *= 2;
    keys_.assign(capacity, empty);
}

bool PairSet::insert(std::uint32_t a, std::uint32_t b) {
    if (2 * (count_ + 1) > keys_.size()) grow();
    const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    std::uint64_t& place = place_of(key);
    if (place == key) return false;
    place = key;
    ++count_;
    return true;
}

std::uint64_t& PairSet::place_of(std::uint64_t key) {
    // Fibonacci hashing [Knuth98, 6.4]: the middle bits of key * 2^64 / golden ratio; linear probing.
    std::size_t i = ((key * 0x9e3779b97f4a7c15u) >> 32) & (keys_.size() - 1);
    while (keys_[i] != empty && keys_[i] != key) i = (i + 1) & (keys_.size() - 1);
    return keys_[i];
}

void PairSet::grow() {
    std::vector<std::uint64_t> old(2 * keys_.size(), empty);
    old.swap(keys_);
    for (const std::uint64_t key : old) {
        if (key != empty) place_of(key) = key;
    }
}

Dcel SweptGraph::dcel() const {
    const auto vertex_count = static_cast<std::uint32_t>(first_right.size());
    Dcel dcel;
    dcel.reserve(vertex_count, edges.size(),
                 1 + edges.size() - std::min<std::size_t>(edges.size(), vertex_count));
    for (std::uint32_t v = 0; v < vertex_count; ++v) dcel.add_vertex();
    for (const Edge& e : edges) dcel.add_edge(VertexId{e.left}, VertexId{e.right});
    const auto end_right = [&](std::uint32_t v) {
        return v + 1 < vertex_count ? first_right[v + 1] : static_cast<std::uint32_t>(edges.size());
    };

    // Counter-clockwise around v leave: its right edges from bottom to top, its left edges from top to
    // bottom. The half-edge that arrives along the twin of the next one goes on along h.
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        HalfEdgeId first, h;
        const auto turn_to = [&](HalfEdgeId next) {
            if (h.valid()) {
                dcel.link(Dcel::twin(next), h);
            } else {
                first = next;
            }
            h = next;
        };
        for (std::uint32_t e = first_right[v]; e < end_right(v); ++e) turn_to(Dcel::half_edge(EdgeId{e}, 0));
        const auto lefts = left_edges[v];
        for (std::size_t i = lefts.size(); i-- > 0;) turn_to(Dcel::half_edge(EdgeId{lefts[i]}, 1));
        if (h.valid()) dcel.link(Dcel::twin(first), h);
    }

    // A cycle leaves its first vertex in xy order along an edge to the right; so, going through the
    // vertices in order, each is first seen from there. It bounds a connected component from outside if
    // and only if it turns, at that vertex, through the direction to the left: there are no left edges,
    // and it goes out along the topmost edge after having come in along the lowest.
    // The face around such a component is the one above the edge below the vertex. That edge starts
    // further left; the cycle above it has been seen.
    const auto face_above = [&](std::uint32_t edge) {
        return edge == none ? Dcel::unbounded_face() : dcel.face(Dcel::half_edge(EdgeId{edge}, 0));
    };
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        const std::uint32_t begin = first_right[v], end = end_right(v);
        if (left_edges[v].empty()) {
            if (begin == end) {
                dcel.add_isolated_vertex(face_above(edge_below[v]), VertexId{v});
                continue;
            }
            const HalfEdgeId topmost = Dcel::half_edge(EdgeId{end - 1}, 0);
            if (!dcel.ccb(topmost).valid()) dcel.add_inner_ccb(face_above(edge_below[v]), topmost);
        }
        for (std::uint32_t e = begin; e < end; ++e) {
            const HalfEdgeId h = Dcel::half_edge(EdgeId{e}, 0);
            if (!dcel.ccb(h).valid()) dcel.add_outer_ccb(dcel.add_face(), h);
        }
    }
    return dcel;
}

}  // namespace detail
}  // namespace vcell
