#include "void_network.hpp"

#include <utility>

#include "../../core/errors.hpp"
#include "../../core/platform.hpp"
#include "network_edges.hpp"
#include "network_passages.hpp"
#include "network_sites.hpp"
#include "network_vertices.hpp"

namespace vcell {

namespace {

// Do all corners of the box lie on one side of a plane, so that nothing of it is nearest to the other one?
bool is_beside(const Box& box, const Plane& plane) {
    bool is_above = true, is_below = true;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p(corner & 1 ? box.max.x() : box.min.x(), corner & 2 ? box.max.y() : box.min.y(),
                     corner & 4 ? box.max.z() : box.min.z());
        const double height = plane.normal.dot(p - plane.point);
        is_above = is_above && height >= 0;
        is_below = is_below && height <= 0;
    }
    return is_above || is_below;
}

}  // namespace

std::string to_string(const NetworkSite& site) {
    return site.site.is_object() ? to_string(ObjectImage{site.site.index, site.image}) : to_string(site.site);
}

std::string names_of(const std::vector<NetworkSite>& sites) {
    std::string names;
    for (const NetworkSite& s : sites) names += (names.empty() ? "" : ", ") + to_string(s.site);
    return names;
}

NetworkSite site_in_diagram(const Cell& cell, const Site& site) {
    if (!site.is_object() || cell.scene.images.empty()) return {site, whole::here};
    const ObjectImage& object = cell.scene.images[site.index];
    return {Site::object(object.number), object.image};
}

class VoidNetworkBuilder::Work {
public:
    explicit Work(const DiagramScene& scene)
        : decided_(scene),
          names_(decided_),
          vertices_(names_),
          edges_(names_, vertices_),
          passages_(names_, vertices_, edges_) {}

    void add(std::uint32_t object, const Cell& cell) try {
        const std::vector<std::uint32_t> sights = vertices_.add(object, cell);
        const whole::FollowedArcs followed =
            edges_.add(object, cell, sights,
                       [&](const whole::NetworkSites& sites) { return passages_.is_border(object, sites); });
        passages_.add(object, cell, followed);
    } catch (const UndecidedError& e) {
        if (undecided_.empty()) undecided_ = e.what();
    }

    VoidNetwork finish(const VoronoiDiagram& diagram) {
        require_cells(diagram);
        if (!undecided_.empty()) throw UndecidedError(undecided_);
        VoidNetwork network;
        network.moved = diagram.moved;
        vertices_.find(network.vertices);
        edges_.find(network.edges);
        passages_.find(network);
        find_spheres(network);
        return network;
    }

private:
    void require_cells(const VoronoiDiagram& diagram) const {
        using State = DiagramCell::State;
        for (std::uint32_t i = 0; i < diagram.cells.size(); ++i) {
            const DiagramCell& cell = diagram.cells[i];
            if (cell.state == State::Undecided || cell.state == State::Refused)
                throw UndecidedError("void network: object " + std::to_string(i) +
                                     " has no cell: " + cell.reason);
            if (cell.state != State::Computed) continue;
            const auto* plane = std::get_if<Plane>(&decided_.scene().objects[i]);
            const std::uint32_t sides = plane == nullptr || is_beside(decided_.scene().box, *plane) ? 1 : 2;
            if (vertices_.cells(i) < sides)
                throw InputError(
                    InputError::Kind::Unsupported, i, "objects[" + std::to_string(i) + "]",
                    decided_.is_ball(i)
                        ? "is centred outside the box, where its cell has no vertices: no void network"
                        : "has a cell without faces (docs/promises.md, Limits): no void network");
        }
    }

    const whole::DecidedDiagram decided_;
    const whole::SiteNames names_;
    whole::NetworkVertices vertices_;
    whole::NetworkEdges edges_;
    whole::NetworkPassages passages_;
    std::string undecided_;  // what the first cell with such a question has
};

VoidNetworkBuilder::VoidNetworkBuilder(const DiagramScene& scene) : work_(std::make_unique<Work>(scene)) {
    if (scene.probe)
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "probe",
                         "ends cells before their vertices, of which a void network is made");
}
VoidNetworkBuilder::~VoidNetworkBuilder() = default;
void VoidNetworkBuilder::add(std::uint32_t object, const Cell& cell) { work_->add(object, cell); }
VoidNetwork VoidNetworkBuilder::finish(const VoronoiDiagram& diagram) { return work_->finish(diagram); }

VoidNetwork void_network(const DiagramScene& scene, const DiagramOptions& options) {
    return in_ieee_arithmetic("void_network()", [&] {
        VoidNetworkBuilder builder(scene);
        DiagramOptions visiting = options;
        visiting.complete = true;
        visiting.visit = [&](std::uint32_t object, const Cell& cell) {
            builder.add(object, cell);
            if (options.visit) options.visit(object, cell);
        };
        const VoronoiDiagram diagram = voronoi_diagram(scene, visiting);
        return builder.finish(diagram);
    });
}

}  // namespace vcell
