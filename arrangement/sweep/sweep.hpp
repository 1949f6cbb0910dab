/// Plane sweep: the arrangement of any set of x-monotone arcs and points.
///
/// [BO79], made complete: any number of arcs through one point, overlaps, vertical arcs, arcs that end
/// inside others, points on arcs. O((n + k) log n) predicates for n arcs and k crossings.
///
/// Predicates are spared where combinatorics knows the answer:
/// - What arrives at an event point is known from the arcs that end there and from the crossings of
///   neighbours found before. The status is searched only for points at which no known arc arrives.
/// - A pair of arcs is intersected at most once.
/// - Arcs of one *layer* (the edges of an arrangement that is being overlaid) are never intersected with
///   each other, and their order around a common end is taken from their numbers.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <vector>

#include "../../core/errors.hpp"
#include "../dcel/dcel.hpp"
#include "arc_geometry.hpp"
#include "sweep_status.hpp"

namespace vcell {

/// A planar subdivision with its geometry.
/// Vertices ascend in xy order. The arc of edge e runs left to right like half-edge 2e; edges ascend by
/// their left vertex and, at one left vertex, from bottom to top. No edge is closed without vertices.
template <ArcGeometry G>
struct Arrangement {
    Dcel dcel;
    IdVector<VertexId, typename G::Point> points;
    IdVector<EdgeId, typename G::Arc> arcs;
};

/// A list of indices for each of a number of elements, in two arrays.
class IndexLists {
public:
    std::size_t size() const { return offsets_.size() - 1; }
    std::span<const std::uint32_t> operator[](std::size_t i) const {
        return {items_.data() + offsets_[i], items_.data() + offsets_[i + 1]};
    }
    /// Extends the list that close() will end.
    void append(std::uint32_t item) { items_.push_back(item); }
    void close() { offsets_.push_back(static_cast<std::uint32_t>(items_.size())); }
    /// `count` lists; list key[i] holds i. Each list ascends.
    static IndexLists by_key(std::span<const std::uint32_t> key, std::size_t count);

private:
    std::vector<std::uint32_t> items_;
    std::vector<std::uint32_t> offsets_{0};
};

/// Arcs and points to sweep over, numbered in the order in which they are added.
template <ArcGeometry G>
struct SweepInput {
    using Point = typename G::Point;
    using Arc = typename G::Arc;
    static constexpr std::uint32_t no_layer = UINT32_MAX;

    std::vector<Point> points;  ///< isolated points and ends of arcs; may repeat
    std::vector<Arc> arcs;
    std::vector<std::uint32_t> lefts, rights;               ///< of each arc: its ends among the points
    std::vector<std::uint32_t> layers;                      ///< of each arc
    std::vector<std::array<std::uint32_t, 2>> sorted_runs;  ///< ranges [i, j) of points that ascend strictly

    void add_arc(G& geometry, const Arc& arc) {
        const auto first = static_cast<std::uint32_t>(points.size());
        points.push_back(geometry.left(arc));
        points.push_back(geometry.right(arc));
        add_arc(arc, first, first + 1, no_layer);
    }
    /// All of an arrangement: vertex v is point (point count before + v), likewise for edges and arcs.
    void add_layer(const Arrangement<G>& arrangement, std::uint32_t layer) {
        const auto first = static_cast<std::uint32_t>(points.size());
        points.insert(points.end(), arrangement.points.begin(), arrangement.points.end());
        sorted_runs.push_back({first, static_cast<std::uint32_t>(points.size())});
        for (const EdgeId e : arrangement.arcs.ids()) {
            const HalfEdgeId h = Dcel::half_edge(e);
            add_arc(arrangement.arcs[e], first + arrangement.dcel.origin(h).value,
                    first + arrangement.dcel.target(h).value, layer);
        }
    }

private:
    void add_arc(const Arc& arc, std::uint32_t left, std::uint32_t right, std::uint32_t layer) {
        arcs.push_back(arc);
        lefts.push_back(left);
        rights.push_back(right);
        layers.push_back(layer);
    }
};

/// The arrangement of a SweepInput, and what each of its elements comes from.
template <ArcGeometry G>
struct SweepResult {
    Arrangement<G> arrangement;
    IndexLists vertex_points;  ///< the input points at each vertex, ends of arcs among them
    IndexLists vertex_arcs;    ///< the input arcs that pass through each vertex, with neither end there
    IndexLists edge_arcs;      ///< the input arcs that run along each edge, in no particular order
};

/// The arrangement of all arcs and points of the input. Throws InternalError where the geometry's answers are
/// seen to contradict each other.
template <ArcGeometry G>
SweepResult<G> sweep(G& geometry, const SweepInput<G>& input);

/// The arrangement of arcs and isolated points in any position and order; they may repeat and overlap.
template <ArcGeometry G>
Arrangement<G> arrange(G& geometry, std::span<const typename G::Arc> arcs,
                       std::span<const typename G::Point> points = {}) {
    SweepInput<G> input;
    for (const auto& arc : arcs) input.add_arc(geometry, arc);
    input.points.insert(input.points.end(), points.begin(), points.end());
    return sweep(geometry, input).arrangement;
}

/// The arrangement with one more arc. Sweeps anew, but only the arc is intersected with the edges:
/// O(n log n) steps, for many arcs sweep over all at once.
template <ArcGeometry G>
Arrangement<G> insert(G& geometry, const Arrangement<G>& arrangement, const typename G::Arc& arc) {
    SweepInput<G> input;
    input.add_layer(arrangement, 0);
    input.add_arc(geometry, arc);
    return sweep(geometry, input).arrangement;
}

// ---------------------------------------------------------------------------------------------------

namespace detail {

/// A set of unordered pairs of indices: open addressing, at most half full.
class PairSet {
public:
    explicit PairSet(std::size_t expected);
    /// False when the pair was there.
    bool insert(std::uint32_t a, std::uint32_t b);

private:
    static constexpr std::uint64_t empty = UINT64_MAX;
    std::uint64_t& place_of(std::uint64_t key);
    void grow();

    std::vector<std::uint64_t> keys_;
    std::size_t count_ = 0;
};

/// The embedded graph that a sweep leaves behind; enough to build the Dcel without geometry.
struct SweptGraph {
    struct Edge {
        std::uint32_t left, right;  ///< vertices
    };
    static constexpr std::uint32_t none = UINT32_MAX;

    std::vector<Edge> edges;                 ///< ascending by left vertex, then from bottom to top
    std::vector<std::uint32_t> first_right;  ///< of each vertex: the first edge whose left end it is
    IndexLists left_edges;                   ///< of each vertex: edges that end there, bottom to top
    std::vector<std::uint32_t> edge_below;   ///< of each vertex without left edges; or none

    Dcel dcel() const;
};

template <ArcGeometry G>
class Sweep {
public:
    using Point = typename G::Point;
    using Arc = typename G::Arc;

    Sweep(G& geometry, const SweepInput<G>& input)
        : g_(geometry),
          input_(input),
          rest_(input.arcs),
          next_in_bundle_(input.arcs.size()),
          node_of_(input.arcs.size()),
          tested_(4 * input.arcs.size()) {}

    SweepResult<G> run() {
        sort_points();
        const auto site_count = static_cast<std::uint32_t>(sites_.size());
        for (std::uint32_t site = 0; site < site_count || !crossings_.empty();) {
            Sign order = Sign::Negative;  // of the next site and the next crossing
            if (site == site_count) {
                order = Sign::Positive;
            } else if (!crossings_.empty()) {
                order = g_.compare_xy(sites_[site], crossings_.front().point);
            }
            arrived_ = 0;
            if (order == Sign::Negative) {
                add_vertex(sites_[site], site);
            } else {
                const Point p = crossings_.front().point;
                do {
                    arrive(crossings_.front().first);
                    arrive(crossings_.front().second);
                    std::pop_heap(crossings_.begin(), crossings_.end(), later());
                    crossings_.pop_back();
                } while (!crossings_.empty() && g_.compare_xy(crossings_.front().point, p) == Sign::Zero);
                add_vertex(p, order == Sign::Zero ? site : none);
            }
            if (order != Sign::Positive) ++site;
        }
        if (status_.first() != SweepStatus::none) throw InternalError("sweep: an arc does not end");
        result_.arrangement.dcel = graph_.dcel();
        return std::move(result_);
    }

private:
    using Node = SweepStatus::Node;
    static constexpr std::uint32_t none = SweptGraph::none;

    /// Arcs `first` and `second` are known to meet at `point`.
    struct Crossing {
        Point point;
        std::uint32_t first, second;
    };

    auto later() {
        return [this](const Crossing& a, const Crossing& b) {
            return g_.compare_xy(a.point, b.point) == Sign::Positive;
        };
    }

    // --- Sites: the different points of the input, ascending. --------------------------------------

    void sort_points() {
        const auto count = static_cast<std::uint32_t>(input_.points.size());
        // Equal points are chained to the one that stands for them.
        std::vector<std::uint32_t> stands_for(count);
        std::iota(stands_for.begin(), stands_for.end(), 0u);

        std::vector<std::uint32_t> loose;
        std::uint32_t i = 0;
        for (const auto& [begin, end] : input_.sorted_runs) {
            for (; i < begin; ++i) loose.push_back(i);
            i = end;
        }
        for (; i < count; ++i) loose.push_back(i);
        std::sort(loose.begin(), loose.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return compare_points(a, b) == Sign::Negative; });
        std::vector<std::uint32_t> sorted;
        sorted.reserve(count);
        for (const std::uint32_t p : loose) {
            if (!sorted.empty() && compare_points(sorted.back(), p) == Sign::Zero) {
                stands_for[p] = sorted.back();
            } else {
                sorted.push_back(p);
            }
        }
        for (const auto& [begin, end] : input_.sorted_runs) sorted = merge(sorted, begin, end, stands_for);

        // From the chains to numbers. A point that was merged late may stand behind another one.
        std::vector<std::uint32_t> site_of(count);
        sites_.reserve(sorted.size());
        for (const std::uint32_t p : sorted) {
            site_of[p] = static_cast<std::uint32_t>(sites_.size());
            sites_.push_back(input_.points[p]);
        }
        for (std::uint32_t p = 0; p < count; ++p) {
            std::uint32_t q = p;
            while (stands_for[q] != q) q = stands_for[q];
            site_of[p] = site_of[q];
        }
        points_at_ = IndexLists::by_key(site_of, sites_.size());
        std::vector<std::uint32_t> left_site(input_.arcs.size());
        right_site_.resize(input_.arcs.size());
        for (std::uint32_t a = 0; a < input_.arcs.size(); ++a) {
            left_site[a] = site_of[input_.lefts[a]];
            right_site_[a] = site_of[input_.rights[a]];
        }
        starts_ = IndexLists::by_key(left_site, sites_.size());
        ends_ = IndexLists::by_key(right_site_, sites_.size());
    }

    Sign compare_points(std::uint32_t a, std::uint32_t b) {
        return g_.compare_xy(input_.points[a], input_.points[b]);
    }

    /// The union of two ascending sequences: `sorted`, and the points of [i, end).
    std::vector<std::uint32_t> merge(const std::vector<std::uint32_t>& sorted, std::uint32_t i,
                                     std::uint32_t end, std::vector<std::uint32_t>& stands_for) {
        std::vector<std::uint32_t> merged;
        merged.reserve(sorted.size() + (end - i));
        for (const std::uint32_t p : sorted) {
            Sign s = Sign::Positive;
            while (i < end && (s = compare_points(i, p)) == Sign::Negative) merged.push_back(i++);
            merged.push_back(p);
            if (i < end && s == Sign::Zero) stands_for[i++] = p;
        }
        while (i < end) merged.push_back(i++);
        return merged;
    }

    // --- Events. -----------------------------------------------------------------------------------

    std::uint32_t current_vertex() const { return static_cast<std::uint32_t>(graph_.first_right.size()); }
    /// The arc that represents those along an edge; only its part from the edge's left vertex on.
    std::uint32_t bundle(Node n) { return bundles_[status_.value(n)]; }

    void arrive(std::uint32_t arc) { arrive_node(node_of_[arc]); }
    void arrive_node(Node n) {
        std::uint32_t& right = graph_.edges[status_.value(n)].right;
        if (right != none) return;
        right = current_vertex();
        ++arrived_;
        some_arrived_ = n;
    }

    /// The sweep line passes p, a site or a mere crossing (site none), at which `arrived_` edges are known to
    /// arrive.
    void add_vertex(const Point& p, std::uint32_t site) {
        const std::uint32_t v = current_vertex();
        if (site != none) {
            for (const std::uint32_t a : ends_[site]) arrive(a);
        }
        Node below = none;
        if (arrived_ == 0) {
            const auto [n, hit] =
                status_.find([&](std::uint32_t edge) { return g_.compare_y_at_x(p, rest_[bundles_[edge]]); });
            if (hit) {
                arrive_node(n);
            } else {
                below = n;
            }
        }
        collect_arrived(v);
        if (!here_.empty()) below = status_.below(here_.front());
        const Node above = !here_.empty()  ? status_.above(here_.back())
                           : below != none ? status_.above(below)
                                           : status_.first();

        outgoing_.clear();
        end_edges(p, site);
        if (site != none) {
            for (const std::uint32_t a : starts_[site]) add_outgoing(a, p);
            for (const std::uint32_t i : points_at_[site]) result_.vertex_points.append(i);
        }
        result_.vertex_points.close();
        graph_.edge_below.push_back(here_.empty() && below != none ? status_.value(below) : none);
        graph_.first_right.push_back(static_cast<std::uint32_t>(graph_.edges.size()));
        result_.arrangement.points.push_back(p);
        start_edges(v, below);

        // New neighbours may meet later.
        if (here_.empty()) {
            if (below != none && above != none) test(below, above, p);
            return;
        }
        if (below != none) test(below, here_.front(), p);
        for (std::size_t i = 1; i < here_.size(); ++i) test(here_[i - 1], here_[i], p);
        if (above != none) test(here_.back(), above, p);
    }

    /// The nodes that arrive at v, bottom to top: they are neighbours of each other.
    void collect_arrived(std::uint32_t v) {
        here_.clear();
        if (arrived_ == 0) return;
        const auto arrives = [&](Node n) { return n != none && graph_.edges[status_.value(n)].right == v; };
        Node n = some_arrived_;
        while (arrives(status_.below(n))) n = status_.below(n);
        for (; arrives(n); n = status_.above(n)) here_.push_back(n);
        if (here_.size() != arrived_) {
            throw InternalError("sweep: the arcs through " + to_string(VertexId{v}) + " are not neighbours");
        }
    }

    /// Ends the edges that arrive at p; their arcs that go on become outgoing.
    void end_edges(const Point& p, std::uint32_t site) {
        for (const Node n : here_) {
            const std::uint32_t edge = status_.value(n);
            graph_.left_edges.append(edge);
            const std::uint32_t first = bundles_[edge];
            for (std::uint32_t a = first, next; a != none; a = next) {
                next = next_in_bundle_[a];
                if (site != none && right_site_[a] == site) continue;
                auto [before, after] = g_.split(rest_[a], p);
                if (a == first) result_.arrangement.arcs[EdgeId{edge}] = before;
                rest_[a] = after;
                result_.vertex_arcs.append(a);
                add_outgoing(a, p);
            }
        }
        graph_.left_edges.close();
        result_.vertex_arcs.close();
    }

    /// Places an arc among the outgoing bundles, which ascend immediately right of p. Arcs that coincide
    /// there form one bundle.
    void add_outgoing(std::uint32_t a, const Point& p) {
        std::size_t begin = 0, end = outgoing_.size();
        while (begin < end) {
            const std::size_t middle = (begin + end) / 2;
            const Sign s = compare_right_of(a, outgoing_[middle], p);
            if (s == Sign::Zero) {
                next_in_bundle_[a] = next_in_bundle_[outgoing_[middle]];
                next_in_bundle_[outgoing_[middle]] = a;
                return;
            }
            (s == Sign::Negative ? end : begin) = s == Sign::Negative ? middle : middle + 1;
        }
        next_in_bundle_[a] = none;
        outgoing_.insert(outgoing_.begin() + static_cast<std::ptrdiff_t>(begin), a);
    }

    Sign compare_right_of(std::uint32_t a, std::uint32_t b, const Point& p) {
        if (same_layer(a, b)) return a < b ? Sign::Negative : Sign::Positive;
        return g_.compare_y_right_of(rest_[a], rest_[b], p);
    }
    bool same_layer(std::uint32_t a, std::uint32_t b) const {
        return input_.layers[a] == input_.layers[b] && input_.layers[a] != SweepInput<G>::no_layer;
    }

    /// Starts an edge for each outgoing bundle. Nodes that have arrived are reused in place: a plain crossing
    /// leaves the status tree as it is. Leaves in here_ the nodes of the new edges, bottom to top.
    void start_edges(std::uint32_t v, Node below) {
        while (here_.size() > outgoing_.size()) {
            status_.erase(here_.back());
            here_.pop_back();
        }
        for (std::size_t i = 0; i < outgoing_.size(); ++i) {
            const auto edge = static_cast<std::uint32_t>(graph_.edges.size());
            if (i < here_.size()) {
                status_.value(here_[i]) = edge;
            } else {
                here_.push_back(status_.insert_above(i == 0 ? below : here_[i - 1], edge));
            }
            const std::uint32_t first = outgoing_[i];
            graph_.edges.push_back({v, none});
            bundles_.push_back(first);
            result_.arrangement.arcs.push_back(rest_[first]);
            for (std::uint32_t a = first; a != none; a = next_in_bundle_[a]) {
                node_of_[a] = here_[i];
                result_.edge_arcs.append(a);
                // Coinciding arcs may part later.
                if (a != first) find_crossings(first, a, result_.arrangement.points.back());
            }
            result_.edge_arcs.close();
        }
    }

    void test(Node m, Node n, const Point& p) { find_crossings(bundle(m), bundle(n), p); }

    /// Queues what two arcs have in common right of p.
    void find_crossings(std::uint32_t a, std::uint32_t b, const Point& p) {
        if (same_layer(a, b) || !tested_.insert(a, b)) return;
        found_.clear();
        g_.intersect(rest_[a], rest_[b], found_);
        const auto queue = [&](const Point& q) {
            if (g_.compare_xy(q, p) != Sign::Positive) return;
            crossings_.push_back({q, a, b});
            std::push_heap(crossings_.begin(), crossings_.end(), later());
        };
        for (const Point& q : found_.points) queue(q);
        for (const Arc& overlap : found_.overlaps) {
            queue(g_.left(overlap));
            queue(g_.right(overlap));
        }
    }

    G& g_;
    const SweepInput<G>& input_;
    SweepResult<G> result_;
    SweptGraph graph_;

    std::vector<Point> sites_;
    IndexLists points_at_, starts_, ends_;   // of each site
    std::vector<std::uint32_t> right_site_;  // of each arc

    std::vector<Crossing> crossings_;            // a heap, the first in xy order on top
    SweepStatus status_;                         // values are edges
    std::vector<Arc> rest_;                      // of each arc: its part from the last vertex on
    std::vector<std::uint32_t> bundles_;         // of each edge: the first arc along it, the others follow in
    std::vector<std::uint32_t> next_in_bundle_;  // this list while the edge is in the status
    std::vector<Node> node_of_;                  // of each arc in the status
    PairSet tested_;

    // Of the current vertex.
    std::size_t arrived_ = 0;
    Node some_arrived_ = none;
    std::vector<Node> here_;
    std::vector<std::uint32_t> outgoing_;
    ArcIntersections<Point, Arc> found_;
};

}  // namespace detail

template <ArcGeometry G>
SweepResult<G> sweep(G& geometry, const SweepInput<G>& input) {
    return detail::Sweep<G>(geometry, input).run();
}

}  // namespace vcell
