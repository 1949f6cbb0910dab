/// The passages of a void network: faces that wind between parallel tubes and planes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "network_edges.hpp"

namespace vcell::whole {

/// A place of the network that an edge leads to: a vertex, or any of an edge that winds. Edges have numbers
/// behind those of the vertices.
struct NetworkPlace {
    std::uint32_t number;
    Image image;

    friend auto operator<=>(const NetworkPlace&, const NetworkPlace&) = default;
};

class NetworkPassages {
public:
    /// All are kept by reference.
    NetworkPassages(const SiteNames& names, const NetworkVertices& vertices, const NetworkEdges& edges)
        : names_(names), vertices_(vertices), edges_(edges) {}

    /// Is what has these sites, one of which is the object, around a face that the object's cell owns, and
    /// that may be a passage?
    bool is_border(std::uint32_t object, const NetworkSites& sites) const;
    /// Takes the faces of a cell. Pre: all arcs around those that may be passages are followed.
    void add(std::uint32_t object, const Cell& cell, const FollowedArcs& followed);
    /// Fills in the network's passages. Throws UndecidedError where cells do not agree about faces. Pre: it
    /// has its vertices and edges.
    void find(VoidNetwork& network) const;

private:
    // An arc around a face, as the cell that owns the face has it.
    struct BorderArc {
        std::optional<std::uint32_t> sight;  // which it leads to; none: it winds, or is closed
        Image image;                         // of the sight's cell
        NetworkSites sites;
        Vec3 point;  // of it
        double error;
        Extremes across;  // the face, from where that is narrowest
    };
    struct Face {
        NetworkSites sites;  // as seen from the owner's cell
        std::vector<BorderArc> arcs;
    };
    class OfPair;

    bool owns_face(std::uint32_t object, const NetworkSite& other) const;
    std::optional<NetworkPlace> place_at(const BorderArc& arc, const VoidNetwork& network) const;

    const SiteNames& names_;
    const NetworkVertices& vertices_;
    const NetworkEdges& edges_;
    std::vector<Face> faces_;
};

}  // namespace vcell::whole
