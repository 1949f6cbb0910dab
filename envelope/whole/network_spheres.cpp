// The spheres of a void network: what fits in, and what gets through.
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "void_network.hpp"

namespace vcell {

namespace {

using Offset = std::array<std::int64_t, 3>;

Offset operator+(const Offset& a, const Offset& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Offset operator-(const Offset& a, const Offset& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// Sets of vertices that edges join, each vertex with the image of it that the edges lead to from the vertex
// that stands for its set (union-find with offsets).
class Windings {
public:
    explicit Windings(std::size_t n) : parent_(n), offset_(n, Offset{0, 0, 0}) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    /// Whoever stands for i's set, and i's image seen from there.
    std::pair<std::uint32_t, Offset> find(std::uint32_t i) {
        std::uint32_t root = i;
        Offset sum{0, 0, 0};
        for (; parent_[root] != root; root = parent_[root]) sum = sum + offset_[root];
        // All on the way are told their root.
        for (Offset rest = sum; parent_[i] != i;) {
            const Offset step = std::exchange(offset_[i], rest);
            i = std::exchange(parent_[i], root);
            rest = rest - step;
        }
        return {root, sum};
    }
    /// Joins two vertices by an edge. The winding that it closes where both are in one set already.
    Offset join(const NetworkEdge& edge) {
        const auto [a, at_a] = find((*edge.vertices)[0]);
        const auto [b, at_b] = find((*edge.vertices)[1]);
        const Offset step{edge.image[0], edge.image[1], edge.image[2]}, way = at_a + step - at_b;
        if (a == b) return way;
        parent_[b] = a;
        offset_[b] = way;
        return {0, 0, 0};
    }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<Offset> offset_;  // from the parent
};

bool winds(const Offset& way) { return way != Offset{0, 0, 0}; }

// The least clearances at which edges, the widest first, close a winding, along any axis and along each.
struct Levels {
    std::optional<double> any;
    std::array<std::optional<double>, 3> along;
};

template <class Weight>
Levels percolation(const VoidNetwork& network, Weight weight) {
    std::vector<const NetworkEdge*> edges;
    for (const NetworkEdge& e : network.edges)
        if (e.vertices) edges.push_back(&e);
    std::ranges::stable_sort(
        edges, [&](const NetworkEdge* a, const NetworkEdge* b) { return weight(*a) > weight(*b); });
    Windings windings(network.vertices.size());
    Levels levels;
    for (const NetworkEdge* e : edges) {
        const Offset way = windings.join(*e);
        if (!winds(way)) continue;
        if (!levels.any) levels.any = weight(*e);
        for (std::size_t k = 0; k < 3; ++k)
            if (way[k] != 0 && !levels.along[k]) levels.along[k] = weight(*e);
    }
    return levels;
}

double lower(const NetworkEdge& e) { return Interval::down(e.bottleneck - e.bottleneck_error); }
double upper(const NetworkEdge& e) { return Interval::up(e.bottleneck + e.bottleneck_error); }

// Twice a clearance between these bounds, of balls that may have moved.
NetworkSphere sphere_between(double low, double high, double moved) {
    const Interval diameter = Interval(2.0) * (Interval(low, high) + Interval(-moved, moved));
    return {diameter.mid(), diameter.radius()};
}

template <class IsIn>
std::optional<NetworkSphere> largest(const VoidNetwork& network, IsIn is_in) {
    std::optional<std::pair<double, double>> most;
    for (std::uint32_t i = 0; i < network.vertices.size(); ++i) {
        if (!is_in(i)) continue;
        const NetworkVertex& v = network.vertices[i];
        const double low = Interval::down(v.clearance - v.error), high = Interval::up(v.clearance + v.error);
        most =
            most ? std::pair(std::max(most->first, low), std::max(most->second, high)) : std::pair(low, high);
    }
    if (!most) return std::nullopt;
    return sphere_between(most->first, most->second, network.moved);
}

// The largest sphere in sets of vertices that wind by edges which may be as wide as `level`.
std::optional<NetworkSphere> largest_along(const VoidNetwork& network, double level) {
    Windings windings(network.vertices.size());
    std::vector<std::uint32_t> on_a_winding;
    for (const NetworkEdge& e : network.edges)
        if (e.vertices && upper(e) >= level && winds(windings.join(e)))
            on_a_winding.push_back((*e.vertices)[0]);
    std::vector<bool> is_wound(network.vertices.size(), false);
    for (const std::uint32_t i : on_a_winding) is_wound[windings.find(i).first] = true;
    return largest(network, [&](std::uint32_t i) { return is_wound[windings.find(i).first]; });
}

}  // namespace

void find_spheres(VoidNetwork& network) {
    network.included = largest(network, [](std::uint32_t) { return true; });
    // Bottlenecks between bounds percolate between those that the bounds percolate at.
    const Levels low = percolation(network, lower), high = percolation(network, upper);
    const auto sphere = [&](const std::optional<double>& a, const std::optional<double>& b) {
        return a && b ? std::optional(sphere_between(*a, *b, network.moved)) : std::nullopt;
    };
    network.free = sphere(low.any, high.any);
    for (std::size_t k = 0; k < 3; ++k) network.free_along[k] = sphere(low.along[k], high.along[k]);
    network.included_along_free = low.any ? largest_along(network, *low.any) : std::nullopt;
}

}  // namespace vcell
