/// The edges of a void network.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "edge_clearance.hpp"
#include "joined_arcs.hpp"
#include "network_vertices.hpp"

namespace vcell::whole {

/// Arcs of the cell of a tube or a plane that are followed where it is cut.
struct FollowedArcs {
    std::vector<CutArc> arcs;
    std::vector<bool> is_owned;                      ///< is the edge taken from this cell?
    std::map<std::uint32_t, std::uint32_t> of_edge;  ///< which arc each of the cell's edges is
    std::vector<JoinedArcs> edges;                   ///< their vertices are sights
};

class NetworkEdges {
public:
    /// Names and vertices are kept by reference.
    NetworkEdges(const SiteNames& names, const NetworkVertices& vertices)
        : names_(names), vertices_(vertices) {}

    /// Takes the edges of a cell. Those between tubes and planes are followed if the cell owns them, and if
    /// `is_followed` says so of their sites. Throws UndecidedError where one cannot be. Pre: the vertices of
    /// the cell are these sights.
    FollowedArcs add(std::uint32_t object, const Cell& cell, const std::vector<std::uint32_t>& sights,
                     const std::function<bool(const NetworkSites&)>& is_followed);

    /// Appends the edges, ascending by sites as seen from their owners. Throws UndecidedError where cells do
    /// not agree about them. Pre: the vertices are found; once.
    void find(std::vector<NetworkEdge>& edges);

    struct Line {
        std::uint32_t edge;  ///< of the network
        Image image;         ///< of it
    };
    /// The edge that winds along its sites, which are parallel, through a point that is known so well; none
    /// if there is none. Throws UndecidedError where it is not told from another one. Pre: edges are found.
    std::optional<Line> line_through(const NetworkSites& sites, const Vec3& point, double error) const;

private:
    struct Arc {
        std::optional<std::array<std::uint32_t, 2>> ends;  // sights
        NetworkEdge edge;     // as seen from its owner's cell; its image is that of the second sight's cell
        Vec3 point{0, 0, 0};  // of one that winds
        double error = 0;     // of that one
        std::uint32_t number = 0;  // in the network, when it is there
    };
    struct ArcCount {
        std::vector<std::uint32_t> of_ball;  // how many each of the sites has that are balls
        std::vector<Arc> arcs;               // those of the owner
    };
    // That an arc ends in a vertex, as a cell has it.
    struct ArcEnd {
        std::uint32_t sight;
        NetworkSites sites;
    };

    void add_owned(std::uint32_t object, const Cell& cell, const CellEdge& edge, SiteNames::Owned owned,
                   const std::array<std::uint32_t, 2>& ends);
    void add_joined(std::uint32_t object, const Cell& cell, const FollowedArcs& followed,
                    const JoinedArcs& joined);
    Extremes clearance(std::uint32_t object, const Cell& cell, const CellEdge& edge) const;
    Interval bottleneck(std::uint32_t object, const Cell& cell, const CellEdge& edge) const;
    void require_same_ends() const;

    const SiteNames& names_;
    const NetworkVertices& vertices_;
    std::map<NetworkSites, ArcCount> edges_;  // by sites as seen from their owners
    std::vector<ArcEnd> ends_;                // of edges that not only balls have
};

}  // namespace vcell::whole
