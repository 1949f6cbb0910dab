/// Which vertex, edge or face of an arrangement holds a point.
#pragma once

#include <cstdint>
#include <vector>

#include "overlay.hpp"

namespace vcell {

namespace detail {

/// A persistent ordered sequence [ST86]: every version stays readable, an update copies the nodes on its way.
/// Treaps with priorities from a hash of the values, so that a version's shape depends on its contents only.
class PersistentSequence {
public:
    using Version = std::uint32_t;
    static constexpr Version empty = UINT32_MAX;

    /// Replaces the values for which side_of(value) is Zero, neighbours of each other, by `values`. Positive:
    /// the place of the change lies above the value.
    template <class SideOf>
    Version replace(Version version, SideOf&& side_of, const std::vector<std::uint32_t>& values) {
        first_new_ = static_cast<Version>(nodes_.size());
        auto [low, high] = split(version, side_of);
        for (const std::uint32_t value : values) low = join(low, add({value, empty, empty}));
        return join(low, high);
    }
    /// As SweepStatus::find, but with values: {value, hit}; {empty, false} when everything lies above.
    template <class SideOf>
    std::pair<std::uint32_t, bool> find(Version version, SideOf&& side_of) const {
        std::uint32_t below = empty;
        while (version != empty) {
            const Node& n = nodes_[version];
            const Sign s = side_of(n.value);
            if (s == Sign::Zero) return {n.value, true};
            if (s == Sign::Positive) below = n.value;
            version = s == Sign::Positive ? n.right : n.left;
        }
        return {below, false};
    }

private:
    struct Node {
        std::uint32_t value;
        Version left, right;
    };

    // A node that this update has made is not part of any version yet and may change.
    Version changed(Version version, const Node& n) {
        if (version < first_new_) return add(n);
        nodes_[version] = n;
        return version;
    }
    Version add(const Node& n) {
        nodes_.push_back(n);
        return static_cast<Version>(nodes_.size() - 1);
    }
    // A bijection of 32-bit words, so that no two values tie (the finaliser of MurmurHash3).
    static std::uint32_t priority(std::uint32_t x) {
        x = (x ^ (x >> 16)) * 0x85ebca6bu;
        x = (x ^ (x >> 13)) * 0xc2b2ae35u;
        return x ^ (x >> 16);
    }
    template <class SideOf>
    std::pair<Version, Version> split(Version version, SideOf&& side_of) {
        if (version == empty) return {empty, empty};
        const Node n = nodes_[version];
        const Sign s = side_of(n.value);
        if (s == Sign::Zero) return {split(n.left, side_of).first, split(n.right, side_of).second};
        const auto [low, high] = split(s == Sign::Positive ? n.right : n.left, side_of);
        if (s == Sign::Positive) return {changed(version, {n.value, n.left, low}), high};
        return {low, changed(version, {n.value, high, n.right})};
    }
    Version join(Version low, Version high) {
        if (low == empty) return high;
        if (high == empty) return low;
        const Node a = nodes_[low], b = nodes_[high];
        if (priority(a.value) > priority(b.value))
            return changed(low, {a.value, a.left, join(a.right, high)});
        return changed(high, {b.value, join(low, b.left), b.right});
    }

    std::vector<Node> nodes_;
    Version first_new_ = 0;
};

}  // namespace detail

/// Answers point location in O(log n) predicates, for any arrangement, after O(n log n) preparation in time
/// and memory: the vertical order of the edges right of every vertex, as versions of one persistent tree.
/// A query finds its vertical strip among the vertices and then the edge below it in that strip's version.
template <ArcGeometry G>
class PointLocator {
public:
    /// Both must outlive the locator; the arrangement must not change.
    PointLocator(G& geometry, const Arrangement<G>& arrangement) : g_(geometry), arrangement_(arrangement) {
        const Dcel& dcel = arrangement.dcel;
        versions_.reserve(dcel.vertex_count());
        auto version = detail::PersistentSequence::empty;
        std::vector<std::uint32_t> rights;
        std::uint32_t edge = 0;
        for (const VertexId v : arrangement.points.ids()) {
            // Edges are numbered by left vertex and from bottom to top: those that start at v follow.
            rights.clear();
            while (edge < dcel.edge_count() && dcel.origin(Dcel::half_edge(EdgeId{edge})) == v)
                rights.push_back(edge++);
            if (dcel.outgoing(v).valid()) {
                version = sequence_.replace(
                    version,
                    [&](std::uint32_t e) {
                        if (dcel.target(Dcel::half_edge(EdgeId{e})) == v) return Sign::Zero;
                        return g_.compare_y_at_x(arrangement.points[v], arrangement.arcs[EdgeId{e}]);
                    },
                    rights);
            }
            versions_.push_back(version);
        }
    }

    Feature locate(const typename G::Point& p) const {
        // The last vertex that is not after p.
        std::uint32_t begin = 0, end = static_cast<std::uint32_t>(arrangement_.points.size());
        while (begin < end) {
            const std::uint32_t middle = begin + (end - begin) / 2;
            const Sign s = g_.compare_xy(p, arrangement_.points[VertexId{middle}]);
            if (s == Sign::Zero) return VertexId{middle};
            (s == Sign::Negative ? end : begin) = s == Sign::Negative ? middle : middle + 1;
        }
        if (begin == 0) return Dcel::unbounded_face();
        const auto [edge, hit] = sequence_.find(versions_[VertexId{begin - 1}], [&](std::uint32_t e) {
            return g_.compare_y_at_x(p, arrangement_.arcs[EdgeId{e}]);
        });
        if (hit) return EdgeId{edge};
        if (edge == detail::PersistentSequence::empty) return Dcel::unbounded_face();
        return arrangement_.dcel.face(Dcel::half_edge(EdgeId{edge}));
    }

private:
    G& g_;
    const Arrangement<G>& arrangement_;
    detail::PersistentSequence sequence_;
    IdVector<VertexId, detail::PersistentSequence::Version> versions_;  // right of each vertex
};

}  // namespace vcell
