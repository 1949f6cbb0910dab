/// The void network of a diagram of balls: where four balls or more are equally near, and the arcs between
/// along which three are; what spheres fit in there, and which of them get through a box that repeats
/// [Willems12].
///
/// Each vertex and each edge appears in the cells of all its sites, and the smallest of them owns it. In all
/// of them it has the same sites, images included: by these it is identified. Where a set of sites has two
/// vertices, and where a cell does not list a ball that it meets in the vertex alone, the vertex is the only
/// one that the errors of both cells leave. No distance is compared with a tolerance.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../cell.hpp"
#include "../voronoi_diagram.hpp"

namespace vcell {

class Interval;

/// A ball of the diagram, moved by so many edges of the box, or a side of the box.
struct NetworkSite {
    Site site;
    std::array<std::int16_t, 3> image{0, 0, 0};

    friend auto operator<=>(const NetworkSite&, const NetworkSite&) = default;
};
/// "3(0,-1,0)", "3" where it is not moved, "box:-x".
std::string to_string(const NetworkSite& site);
/// A site of a diagram's cell (DiagramOptions::visit) as the diagram names it, its image as seen from the
/// cell's own object.
NetworkSite site_in_diagram(const Cell& cell, const Site& site);

/// A point equally far from its balls, farther from all others; in the scene's unit, as everything here. Of
/// a lattice's it is one for all images: the one that its first ball, image 0, 0, 0, has.
struct NetworkVertex {
    Vec3 point;
    double clearance = 0;
    double error = 0;                ///< bounds the distance from the true vertex, and the clearance's
    std::vector<NetworkSite> sites;  ///< ascending; three balls only where a side of the box is among them
    bool is_touching = false;        ///< as CellVertex::is_touching
};

/// An arc of points equally far from three balls or more, maximal between vertices.
struct NetworkEdge {
    /// None: the arc is closed and meets no vertex.
    std::optional<std::array<std::uint32_t, 2>> vertices;
    /// Of the second vertex, where the first one has 0, 0, 0.
    std::array<std::int16_t, 3> image{0, 0, 0};
    std::vector<NetworkSite> sites;  ///< ascending, as seen from the first vertex
    /// The least clearance along the edge; a proven bound.
    double bottleneck = 0, bottleneck_error = 0;
    double length = 0, length_error = 0;  ///< as CellEdge's
};

struct NetworkSphere {
    double diameter = 0, error = 0;  ///< a proven bound; the diameter is negative where nothing fits
};

struct VoidNetwork {
    std::vector<NetworkVertex> vertices;  ///< ascending by sites
    std::vector<NetworkEdge> edges;       ///< ascending by sites as seen from the smallest
    /// Di: the largest sphere about a vertex. None without vertices.
    std::optional<NetworkSphere> included;
    /// Df: the largest sphere that gets along edges from a vertex to an image of it; and so along each axis.
    /// None where edges do not lead there.
    std::optional<NetworkSphere> free;
    std::array<std::optional<NetworkSphere>, 3> free_along;
    /// Dif: the largest sphere about a vertex that a sphere as large as Df, or smaller by no more than its
    /// error, reaches on its way.
    std::optional<NetworkSphere> included_along_free;
    /// A bound on the distance that balls were moved by (VoronoiDiagram::moved). It is part of the errors of
    /// spheres; those of vertices and edges are about the balls where they were moved to.
    double moved = 0;
};

namespace whole {
class DecidedDiagram;
}

/// Makes the network while a diagram is computed.
class VoidNetworkBuilder {
public:
    /// Throws InputError for objects that are no balls and for a probe, and as voronoi_diagram().
    explicit VoidNetworkBuilder(const DiagramScene& scene);
    ~VoidNetworkBuilder();
    VoidNetworkBuilder(const VoidNetworkBuilder&) = delete;
    VoidNetworkBuilder& operator=(const VoidNetworkBuilder&) = delete;

    /// To be called with all cells: DiagramOptions::visit. What is undecided in one is told by finish().
    void add(std::uint32_t object, const Cell& cell);
    /// Throws UndecidedError where a cell is missing, where two do not agree about what they share, and where
    /// errors do not tell two vertices of the same sites apart; InputError where a ball's centre lies outside
    /// the box, as its cell has no vertices there. Pre: the diagram is that of the scene, all its cells were
    /// added.
    VoidNetwork finish(const VoronoiDiagram& diagram);

private:
    using Image = std::array<std::int16_t, 3>;
    using Sites = std::vector<NetworkSite>;

    // A vertex as a cell has it; its sites, the cell's ball among them, ascending.
    struct Sight {
        std::uint32_t cell;
        Sites sites;
        Vec3 point;
        double clearance, error;
        bool is_touching;
        // Of the network, when it is known, and where its smallest site's own image is here.
        std::uint32_t vertex = UINT32_MAX;
        Image by{0, 0, 0};
    };
    struct Arc {
        std::optional<std::array<std::uint32_t, 2>> ends;  // sights
        NetworkEdge edge;                                  // as seen from the smallest of its sites
    };
    struct ArcCount {
        std::vector<std::uint32_t> of_owner;  // how many each of the sites has
        std::vector<Arc> arcs;                // those of the smallest
    };

    const Sphere& ball_in(const Cell& cell, const Site& site) const;
    Sites sites_in(const Cell& cell, std::uint32_t object, const std::vector<Site>& sites) const;
    void add_vertices_and_edges(std::uint32_t object, const Cell& cell);
    void add_edge(std::uint32_t object, const Cell& cell, const CellEdge& edge,
                  const std::vector<std::uint32_t>& sights);
    Interval bottleneck(std::uint32_t object, const Cell& cell, const CellEdge& edge,
                        const std::vector<Site>& sites) const;
    bool are_apart(const Sight& a, const Sight& b, const Image& image) const;
    std::uint32_t sight_of(const Sight& sight, const NetworkSite& site) const;
    NetworkVertex vertex_of(std::uint32_t sight, std::uint32_t number);
    void find_vertices(VoidNetwork& network);
    void find_edges(VoidNetwork& network) const;

    std::unique_ptr<whole::DecidedDiagram> decided_;
    std::vector<bool> has_cell_;
    std::string undecided_;  // what the first cell with such a question has
    std::vector<Sight> sights_;
    std::vector<std::array<std::uint32_t, 2>> sights_of_;  // of each cell: from, to
    std::map<Sites, ArcCount> edges_;
};

/// The network of a scene whose diagram is not needed otherwise. Throws as the builder.
VoidNetwork void_network(const DiagramScene& scene, const DiagramOptions& options = {});

/// Fills in included, free, free_along and included_along_free from vertices, edges and moved. Paths count
/// along axes along which the box repeats: others have no images.
void find_spheres(VoidNetwork& network);

}  // namespace vcell
