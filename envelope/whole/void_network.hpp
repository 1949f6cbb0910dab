/// The void network of a diagram: where four objects or more are equally near, and the arcs between along
/// which three are; what spheres fit in there, and which of them get through a box that repeats [Willems12].
///
/// Each vertex and each edge appears in the cells of all its sites. By these it is identified, images
/// included, but for what leaves a tube or a plane as it is. Where a set of sites has two vertices, and where
/// a cell does not list a site that it meets in the vertex alone, the vertex is the only one that the errors
/// of both cells leave. No distance is compared with a tolerance. An edge is that of its smallest ball, as
/// cells of balls are whole; between tubes and planes it is that of the smallest tube, else of the smallest
/// plane, where the cell is cut being joined (joined_arcs.hpp). Vessels have no cells and are sites like
/// others.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../cell.hpp"
#include "../voronoi_diagram.hpp"

namespace vcell {

/// An object of the diagram, moved by so many edges of the box, or a side of the box. Of a tube, a plane or a
/// vessel one image stands for all that differ by what leaves it as it is (VoronoiDiagram::periods).
struct NetworkSite {
    Site site;
    std::array<std::int16_t, 3> image{0, 0, 0};

    friend auto operator<=>(const NetworkSite&, const NetworkSite&) = default;
};
/// "3(0,-1,0)", "3" where it is not moved, "box:-x".
std::string to_string(const NetworkSite& site);
/// "3, 5, box:-x", without images: for messages.
std::string names_of(const std::vector<NetworkSite>& sites);
/// A site of a diagram's cell (DiagramOptions::visit) as the diagram names it, its image as seen from the
/// cell's own object.
NetworkSite site_in_diagram(const Cell& cell, const Site& site);

/// A point equally far from its objects, farther from all others; in the scene's unit, as everything here. Of
/// a lattice's it is one for all images: the one that its first object with a cell, image 0, 0, 0, has.
struct NetworkVertex {
    Vec3 point;
    double clearance = 0;
    double error = 0;                ///< bounds the distance from the true vertex, and the clearance's
    std::vector<NetworkSite> sites;  ///< ascending; three objects only where a side of the box is among them
    bool is_touching = false;        ///< as CellVertex::is_touching
};

/// An arc of points equally far from three objects or more, maximal between vertices.
struct NetworkEdge {
    /// None: the arc meets no vertex. It is closed, or it winds.
    std::optional<std::array<std::uint32_t, 2>> vertices;
    /// Where the second vertex is, if the first one has 0, 0, 0. Without vertices, where any of the arc's
    /// points is when the arc comes to it again: 0, 0, 0 if it is closed; else it winds through the box.
    std::array<std::int16_t, 3> image{0, 0, 0};
    std::vector<NetworkSite> sites;  ///< ascending, as seen from the first vertex
    /// The least clearance along the edge; a proven bound.
    double bottleneck = 0, bottleneck_error = 0;
    double widest = 0, widest_error = 0;  ///< the greatest one, of an edge that winds
    double length = 0, length_error = 0;  ///< as CellEdge's

    bool winds() const { return !vertices && image != std::array<std::int16_t, 3>{0, 0, 0}; }
};

/// A face between two parallel objects, tubes or planes, that winds through the box as they do: it lies
/// between edges that no vertices join, and spheres get across it, between the two objects.
struct NetworkPassage {
    std::array<std::uint32_t, 2> edges{};
    /// Where the second edge is, if the first one is as the network has it.
    std::array<std::int16_t, 3> image{0, 0, 0};
    std::vector<NetworkSite> sites;  ///< the two, as seen from the first edge
    /// The least clearance on the widest way across the face; a proven bound, which is wide where one of the
    /// edges comes to both sides of where the face is narrowest.
    double bottleneck = 0, bottleneck_error = 0;
};

struct NetworkSphere {
    double diameter = 0, error = 0;  ///< a proven bound; the diameter is negative where nothing fits
};

struct VoidNetwork {
    std::vector<NetworkVertex> vertices;   ///< ascending by sites
    std::vector<NetworkEdge> edges;        ///< ascending by sites as seen from that whose cell has it
    std::vector<NetworkPassage> passages;  ///< ascending; none where the box does not repeat
    /// Di: the largest sphere about a vertex, or about a point of an edge that winds. None without these.
    std::optional<NetworkSphere> included;
    /// Df: the largest sphere that gets along edges and passages from a place to an image of it; and so along
    /// each axis. None where these do not lead there.
    std::optional<NetworkSphere> free;
    std::array<std::optional<NetworkSphere>, 3> free_along;
    /// Dif: the largest sphere, as in Di, about a place that a sphere as large as Df, or smaller by no more
    /// than its error, reaches on its way.
    std::optional<NetworkSphere> included_along_free;
    /// A bound on the distance that objects were moved by (VoronoiDiagram::moved). It is part of the errors
    /// of spheres; those of vertices and edges are about the objects where they were moved to.
    double moved = 0;
};

/// Makes the network while a diagram is computed.
class VoidNetworkBuilder {
public:
    /// Throws InputError for a probe, and as voronoi_diagram().
    explicit VoidNetworkBuilder(const DiagramScene& scene);
    ~VoidNetworkBuilder();
    VoidNetworkBuilder(const VoidNetworkBuilder&) = delete;
    VoidNetworkBuilder& operator=(const VoidNetworkBuilder&) = delete;

    /// To be called with all cells: DiagramOptions::visit, complete if not all objects are balls. What is
    /// undecided in one is told by finish().
    void add(std::uint32_t object, const Cell& cell);
    /// Throws UndecidedError where a cell is missing, where two do not agree about what they share, where
    /// errors do not tell two vertices of the same sites apart, and where an edge is not proved to go on at a
    /// cut; InputError where the cell of an object has no vertices, as of a ball whose centre lies outside
    /// the box. Pre: the diagram is that of the scene, all its cells were added.
    VoidNetwork finish(const VoronoiDiagram& diagram);

private:
    class Work;
    std::unique_ptr<Work> work_;
};

/// The network of a scene whose diagram is not needed otherwise. Throws as the builder.
VoidNetwork void_network(const DiagramScene& scene, const DiagramOptions& options = {});

/// Fills in included, free, free_along and included_along_free from vertices, edges and moved. Paths count
/// along axes along which the box repeats: others have no images.
void find_spheres(VoidNetwork& network);

}  // namespace vcell
