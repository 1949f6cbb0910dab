// The spheres of a void network: what fits in, and what gets through.
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "void_network.hpp"
#include "windings.hpp"

namespace vcell {

namespace {

using whole::Offset;
using whole::offset;
using whole::Windings;
using whole::winds;

// A way between two places: vertices, and behind these edges that wind.
struct Way {
    std::uint32_t from, to;
    Offset offset;
    double low, high;  // of the clearance along it
};

std::uint32_t first_place(const VoidNetwork& network, std::uint32_t edge) {
    const NetworkEdge& e = network.edges[edge];
    return e.vertices ? (*e.vertices)[0] : static_cast<std::uint32_t>(network.vertices.size()) + edge;
}

std::vector<Way> ways_of(const VoidNetwork& network) {
    std::vector<Way> ways;
    const auto add = [&](std::uint32_t from, std::uint32_t to, const auto& by) {
        ways.push_back({from, to, offset(by.image), Interval::down(by.bottleneck - by.bottleneck_error),
                        Interval::up(by.bottleneck + by.bottleneck_error)});
    };
    for (std::uint32_t i = 0; i < network.edges.size(); ++i) {
        const NetworkEdge& e = network.edges[i];
        if (e.vertices || e.winds())
            add(first_place(network, i), e.vertices ? (*e.vertices)[1] : first_place(network, i), e);
    }
    for (const NetworkPassage& p : network.passages)
        add(first_place(network, p.edges[0]), first_place(network, p.edges[1]), p);
    return ways;
}

// The least clearances at which ways, the widest first, close a winding, along any axis and along each.
struct Levels {
    std::optional<double> any;
    std::array<std::optional<double>, 3> along;
};

Levels percolation(const VoidNetwork& network, std::vector<Way> ways, double Way::*bound) {
    std::ranges::stable_sort(ways, [&](const Way& a, const Way& b) { return a.*bound > b.*bound; });
    Windings windings(network.vertices.size() + network.edges.size());
    Levels levels;
    for (const Way& w : ways) {
        const Offset closed = windings.join(w.from, w.to, w.offset);
        if (!winds(closed)) continue;
        if (!levels.any) levels.any = w.*bound;
        for (std::size_t k = 0; k < 3; ++k)
            if (closed[k] != 0 && !levels.along[k]) levels.along[k] = w.*bound;
    }
    return levels;
}

// Twice a clearance between these bounds, of balls that may have moved.
NetworkSphere sphere_between(double low, double high, double moved) {
    const Interval diameter = Interval(2.0) * (Interval(low, high) + Interval(-moved, moved));
    return {diameter.mid(), diameter.radius()};
}

// The largest sphere about one of those vertices, or about a point of one of those edges that wind.
template <class Has>
std::optional<NetworkSphere> largest(const VoidNetwork& network, Has has) {
    std::optional<std::pair<double, double>> most;
    const auto add = [&](double clearance, double error) {
        const double low = Interval::down(clearance - error), high = Interval::up(clearance + error);
        most =
            most ? std::pair(std::max(most->first, low), std::max(most->second, high)) : std::pair(low, high);
    };
    for (std::uint32_t i = 0; i < network.vertices.size(); ++i)
        if (has(i)) add(network.vertices[i].clearance, network.vertices[i].error);
    for (std::uint32_t i = 0; i < network.edges.size(); ++i)
        if (const NetworkEdge& e = network.edges[i]; e.winds() && has(first_place(network, i)))
            add(e.widest, e.widest_error);
    if (!most) return std::nullopt;
    return sphere_between(most->first, most->second, network.moved);
}

// The largest sphere in sets of places that wind by ways which may be as wide as `level`.
std::optional<NetworkSphere> largest_along(const VoidNetwork& network, const std::vector<Way>& ways,
                                           double level) {
    Windings windings(network.vertices.size() + network.edges.size());
    std::vector<std::uint32_t> on_a_winding;
    for (const Way& w : ways)
        if (w.high >= level && winds(windings.join(w.from, w.to, w.offset))) on_a_winding.push_back(w.from);
    std::vector<bool> is_wound(network.vertices.size() + network.edges.size(), false);
    for (const std::uint32_t i : on_a_winding) is_wound[windings.find(i).first] = true;
    return largest(network, [&](std::uint32_t i) { return is_wound[windings.find(i).first]; });
}

}  // namespace

void find_spheres(VoidNetwork& network) {
    network.included = largest(network, [](std::uint32_t) { return true; });
    const std::vector<Way> ways = ways_of(network);
    // Bottlenecks between bounds percolate between those that the bounds percolate at.
    const Levels low = percolation(network, ways, &Way::low), high = percolation(network, ways, &Way::high);
    const auto sphere = [&](const std::optional<double>& a, const std::optional<double>& b) {
        return a && b ? std::optional(sphere_between(*a, *b, network.moved)) : std::nullopt;
    };
    network.free = sphere(low.any, high.any);
    for (std::size_t k = 0; k < 3; ++k) network.free_along[k] = sphere(low.along[k], high.along[k]);
    network.included_along_free = low.any ? largest_along(network, ways, *low.any) : std::nullopt;
}

}  // namespace vcell
