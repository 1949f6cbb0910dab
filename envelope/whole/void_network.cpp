#include "void_network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "../../core/errors.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/platform.hpp"
#include "cell_finder.hpp"
#include "edge_clearance.hpp"

namespace vcell {

namespace {

using Image = std::array<std::int16_t, 3>;
constexpr Image here{0, 0, 0};

Image minus(const Image& a, const Image& b) {
    Image difference;
    for (std::size_t k = 0; k < 3; ++k) difference[k] = static_cast<std::int16_t>(a[k] - b[k]);
    return difference;
}

Image plus(const Image& a, const Image& b) { return minus(a, minus(here, b)); }

void move_back(std::vector<NetworkSite>& sites, const Image by) {
    for (NetworkSite& s : sites)
        if (s.site.is_object()) s.image = minus(s.image, by);
}

std::string names_of(const std::vector<NetworkSite>& sites) {
    std::string names;
    for (const NetworkSite& s : sites) names += (names.empty() ? "" : ", ") + to_string(s.site);
    return names;
}

}  // namespace

std::string to_string(const NetworkSite& site) {
    return site.site.is_object() ? to_string(ObjectImage{site.site.index, site.image}) : to_string(site.site);
}

NetworkSite site_in_diagram(const Cell& cell, const Site& site) {
    if (!site.is_object() || cell.scene.images.empty()) return {site, here};
    const ObjectImage& object = cell.scene.images[site.index];
    return {Site::object(object.number), object.image};
}

VoidNetworkBuilder::VoidNetworkBuilder(const DiagramScene& scene)
    : decided_(std::make_unique<whole::DecidedDiagram>(scene)),
      has_cell_(scene.objects.size(), false),
      sights_of_(scene.objects.size(), {0, 0}) {
    if (scene.probe)
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "probe",
                         "ends cells before their vertices, of which a void network is made");
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (!decided_->is_ball(i))
            throw InputError(InputError::Kind::Unsupported, i, "objects[" + std::to_string(i) + "]",
                             "is no ball, and a void network is that of balls");
}
VoidNetworkBuilder::~VoidNetworkBuilder() = default;

const Sphere& VoidNetworkBuilder::ball_in(const Cell& cell, const Site& site) const {
    const bool is_own = decided_->scene().is_periodic();
    return is_own ? std::get<Sphere>(cell.scene.objects[site.index]) : decided_->ball(site.index);
}

VoidNetworkBuilder::Sites VoidNetworkBuilder::sites_in(const Cell& cell, std::uint32_t object,
                                                       const std::vector<Site>& sites) const {
    Sites result{{Site::object(object), here}};
    for (const Site& site : sites) result.push_back(site_in_diagram(cell, site));
    std::ranges::sort(result);
    return result;
}

void VoidNetworkBuilder::add(std::uint32_t object, const Cell& cell) try {
    has_cell_[object] = true;
    add_vertices_and_edges(object, cell);
} catch (const UndecidedError& e) {
    if (undecided_.empty()) undecided_ = e.what();
}

void VoidNetworkBuilder::add_vertices_and_edges(std::uint32_t object, const Cell& cell) {
    std::vector<std::uint32_t> sights(cell.vertices.size(), UINT32_MAX);
    sights_of_[object][0] = static_cast<std::uint32_t>(sights_.size());
    for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
        const CellVertex& v = cell.vertices[i];
        const auto balls = std::ranges::count_if(v.sites, [](const Site& s) { return s.is_object(); });
        if (balls < 2) continue;
        sights[i] = static_cast<std::uint32_t>(sights_.size());
        sights_.push_back({object, sites_in(cell, object, {v.sites.begin(), v.sites.end()}), v.point,
                           v.radius, v.error, v.is_touching});
    }
    sights_of_[object][1] = static_cast<std::uint32_t>(sights_.size());
    for (const CellEdge& edge : cell.edges) add_edge(object, cell, edge, sights);
}

void VoidNetworkBuilder::add_edge(std::uint32_t object, const Cell& cell, const CellEdge& edge,
                                  const std::vector<std::uint32_t>& sights) {
    std::vector<Site> sites(edge.sites.begin(), edge.sites.end());
    sites.insert(sites.end(), edge.extra_sites.begin(), edge.extra_sites.end());
    if (!std::ranges::all_of(sites, [](const Site& s) { return s.is_object(); })) return;
    // As seen from the smallest site, which is the first: whatever sites are moved by, their order stays.
    Sites seen = sites_in(cell, object, sites);
    const NetworkSite self{Site::object(object), minus(here, seen.front().image)};
    move_back(seen, seen.front().image);
    const auto owner = static_cast<std::size_t>(std::ranges::find(seen, self) - seen.begin());
    ArcCount& count = edges_[seen];
    count.of_owner.resize(seen.size());
    ++count.of_owner[owner];
    if (owner != 0) return;

    Arc arc;
    arc.edge.sites = std::move(seen);
    arc.edge.length = edge.length;
    arc.edge.length_error = edge.length_error;
    if (!edge.vertices.empty()) {
        arc.ends = {sights[edge.vertices.front()], sights[edge.vertices.back()]};
        if (std::ranges::max(*arc.ends) == UINT32_MAX)
            throw InternalError("void network: an edge of three balls ends where two are");
    }
    const Interval least = bottleneck(object, cell, edge, sites);
    arc.edge.bottleneck = least.mid();
    arc.edge.bottleneck_error = least.radius();
    count.arcs.push_back(std::move(arc));
}

Interval VoidNetworkBuilder::bottleneck(std::uint32_t object, const Cell& cell, const CellEdge& edge,
                                        const std::vector<Site>& sites) const {
    constexpr double u = std::numeric_limits<double>::epsilon();
    const Sphere& self = decided_->ball(object);
    // Of a handful of operations on coordinates as large as the point's.
    const auto rounding = [&](const Vec3& p) {
        return 16 * u * (p.cwiseAbs().sum() + self.center.cwiseAbs().sum() + self.radius);
    };
    whole::EdgeArc arc;
    const double begin = edge.curve.domain_begin();
    arc.middle.point = edge.curve.evaluate(std::midpoint(begin, edge.curve.domain_end()));
    arc.middle.error = edge.error + rounding(arc.middle.point);
    if (edge.vertices.empty()) {
        const Vec3 p = edge.curve.evaluate(begin);
        arc.ends[0] = {p, (p - self.center).norm() - self.radius, edge.error + rounding(p)};
        arc.ends[1] = arc.ends[0];
        arc.is_closed = true;
    } else {
        for (const std::size_t k : {0, 1}) {
            const CellVertex& v = cell.vertices[k == 0 ? edge.vertices.front() : edge.vertices.back()];
            arc.ends[k] = {v.point, v.radius, v.error};
        }
        arc.is_closed = edge.vertices.front() == edge.vertices.back();
    }
    if (std::isfinite(edge.length) && !edge.is_estimated)
        arc.length = Interval::up(edge.length + edge.length_error);
    // Any three of the balls tell it.
    for (std::size_t a = 0; a + 1 < sites.size(); ++a)
        for (std::size_t b = a + 1; b < sites.size(); ++b)
            if (const auto least =
                    whole::least_clearance({self, ball_in(cell, sites[a]), ball_in(cell, sites[b])}, arc))
                return *least;
    throw UndecidedError("void network: the least clearance along an edge of object " +
                         std::to_string(object) + " could not be enclosed");
}

// Do the errors tell that b, of a cell that is at `image` of a's, is another vertex than a? Those of touching
// vertices bound no places.
bool VoidNetworkBuilder::are_apart(const Sight& a, const Sight& b, const Image& image) const {
    const Vec3 other = b.point + decided_->balls().lattice().shift(image);
    const double rounding = 8 * std::numeric_limits<double>::epsilon() *
                            (a.point.cwiseAbs().sum() + b.point.cwiseAbs().sum() + other.cwiseAbs().sum());
    return !a.is_touching && !b.is_touching && (a.point - other).norm() > a.error + b.error + rounding;
}

// The vertex as the cell of one of its sites has it: that cell has it, as the site ties there. It is the one
// of the same sites, or, where these are of two vertices or where a cell leaves some out, the one that is not
// apart. Balls that a cell meets in a vertex alone may have been left out of it, as they own nothing there.
std::uint32_t VoidNetworkBuilder::sight_of(const Sight& sight, const NetworkSite& site) const {
    const auto [from, to] = sights_of_[site.site.index];
    const auto has_same_sites = [&](const Sight& other) {
        return std::ranges::equal(sight.sites, other.sites, [&](const NetworkSite& a, const NetworkSite& b) {
            return a.site == b.site && (!a.site.is_object() || minus(a.image, b.image) == site.image);
        });
    };
    for (const bool is_by_sites : {true, false}) {
        std::uint32_t found = UINT32_MAX, count = 0, left = 0, last = UINT32_MAX;
        for (std::uint32_t s = from; s < to; ++s) {
            if (is_by_sites && !has_same_sites(sights_[s])) continue;
            ++count;
            last = s;
            if (are_apart(sight, sights_[s], site.image)) continue;
            ++left;
            found = s;
        }
        if (is_by_sites && count == 1) return last;
        if (left == 1) return found;
        if (count > 0 && is_by_sites) break;
    }
    throw UndecidedError("void network: the vertex of objects " + names_of(sight.sites) +
                         " is not told from others in the cell of object " + to_string(site.site));
}

// A vertex, found from one cell's sight of it; all cells' sights are told its number.
NetworkVertex VoidNetworkBuilder::vertex_of(std::uint32_t sight, std::uint32_t number) {
    // Where the cells are that have it, in images as seen from the first.
    std::map<NetworkSite, std::uint32_t> seen{{{Site::object(sights_[sight].cell), here}, sight}};
    Sites waiting{seen.begin()->first}, sides;
    while (!waiting.empty()) {
        const NetworkSite at = waiting.back();
        waiting.pop_back();
        const Sight& a = sights_[seen.at(at)];
        for (const NetworkSite& site : a.sites) {
            if (!site.site.is_object()) {
                sides.push_back(site);
                continue;
            }
            const NetworkSite there{site.site, plus(at.image, site.image)};
            if (seen.contains(there)) continue;
            seen.emplace(there, sight_of(a, site));
            waiting.push_back(there);
        }
    }
    const Image by = seen.begin()->first.image;
    NetworkVertex vertex;
    for (const auto& [site, s] : seen) {
        vertex.sites.push_back({site.site, minus(site.image, by)});
        Sight& a = sights_[s];
        if (std::exchange(a.vertex, number) != UINT32_MAX)
            throw UndecidedError("void network: two vertices of objects " + names_of(a.sites) +
                                 " are the same one in the cell of object " + std::to_string(a.cell));
        a.by = minus(by, site.image);
    }
    std::ranges::sort(sides);
    sides.erase(std::ranges::unique(sides).begin(), sides.end());
    vertex.sites.insert(vertex.sites.end(), sides.begin(), sides.end());
    const Sight& own = sights_[seen.begin()->second];
    vertex.point = own.point;
    vertex.clearance = own.clearance;
    vertex.error = own.error;
    vertex.is_touching = own.is_touching;
    return vertex;
}

void VoidNetworkBuilder::find_vertices(VoidNetwork& network) {
    for (std::uint32_t s = 0; s < sights_.size(); ++s)
        if (sights_[s].vertex == UINT32_MAX)
            network.vertices.push_back(vertex_of(s, static_cast<std::uint32_t>(network.vertices.size())));
    std::vector<std::uint32_t> order(network.vertices.size()), place(order.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {},
                             [&](std::uint32_t i) -> const Sites& { return network.vertices[i].sites; });
    std::vector<NetworkVertex> sorted;
    sorted.reserve(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        place[order[i]] = i;
        sorted.push_back(std::move(network.vertices[order[i]]));
    }
    network.vertices = std::move(sorted);
    for (Sight& sight : sights_) sight.vertex = place[sight.vertex];
}

void VoidNetworkBuilder::find_edges(VoidNetwork& network) const {
    for (const auto& [sites, count] : edges_) {
        for (const std::uint32_t n : count.of_owner)
            if (n != count.of_owner[0])
                throw UndecidedError("void network: cells do not agree about edges of objects " +
                                     names_of(sites));
        for (const Arc& arc : count.arcs) {
            NetworkEdge edge = arc.edge;
            if (arc.ends) {
                const Sight &a = sights_[(*arc.ends)[0]], &b = sights_[(*arc.ends)[1]];
                edge.vertices = {a.vertex, b.vertex};
                edge.image = minus(b.by, a.by);
                move_back(edge.sites, a.by);
            }
            network.edges.push_back(std::move(edge));
        }
    }
}

VoidNetwork VoidNetworkBuilder::finish(const VoronoiDiagram& diagram) {
    using State = DiagramCell::State;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        if (cell.state == State::Undecided || cell.state == State::Refused)
            throw UndecidedError("void network: object " + std::to_string(i) +
                                 " has no cell: " + cell.reason);
        if (cell.state == State::Computed && !has_cell_[i])
            throw InputError(InputError::Kind::Unsupported, i, "objects[" + std::to_string(i) + "]",
                             "is centred outside the box, where its cell has no vertices: no void network");
    }
    if (!undecided_.empty()) throw UndecidedError(undecided_);
    VoidNetwork network;
    network.moved = diagram.moved;
    find_vertices(network);
    find_edges(network);
    find_spheres(network);
    return network;
}

VoidNetwork void_network(const DiagramScene& scene, const DiagramOptions& options) {
    return in_ieee_arithmetic("void_network()", [&] {
        VoidNetworkBuilder builder(scene);
        DiagramOptions visiting = options;
        visiting.visit = [&](std::uint32_t object, const Cell& cell) {
            builder.add(object, cell);
            if (options.visit) options.visit(object, cell);
        };
        const VoronoiDiagram diagram = voronoi_diagram(scene, visiting);
        return builder.finish(diagram);
    });
}

}  // namespace vcell
