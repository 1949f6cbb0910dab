#include "void_network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "../../core/errors.hpp"
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

void move_back(std::vector<NetworkSite>& sites, const Image& by) {
    for (NetworkSite& s : sites)
        if (s.site.is_object()) s.image = minus(s.image, by);
}

std::string names_of(const std::vector<NetworkSite>& sites) {
    std::string names;
    for (const NetworkSite& s : sites) names += (names.empty() ? "" : ", ") + to_string(s.site);
    return names;
}

}  // namespace

VoidNetworkBuilder::VoidNetworkBuilder(const DiagramScene& scene)
    : decided_(std::make_unique<whole::DecidedDiagram>(scene)), has_cell_(scene.objects.size(), false) {
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

// In a box that repeats, cells number their candidates by themselves; places are exact, so a ball is found by
// where it is. Equal and hidden balls are in no cell.
NetworkSite VoidNetworkBuilder::site_in(const Cell& cell, const Site& site) const {
    if (!site.is_object() || !decided_->scene().is_periodic()) return {site, here};
    const Sphere& ball = ball_in(cell, site);
    std::optional<NetworkSite> found;
    const double reach = -ball.radius + 0x1p-40 * (ball.radius + ball.center.cwiseAbs().sum() +
                                                   std::numeric_limits<double>::min());
    decided_->within(ball.center, reach, UINT32_MAX,
                     [&](const Sphere& other, std::uint32_t number, const Image& image) {
                         if (other == ball) found = NetworkSite{Site::object(number), image};
                     });
    if (!found) throw InternalError("void network: a cell has a ball that the diagram has not");
    return *found;
}

VoidNetworkBuilder::Sites VoidNetworkBuilder::sites_in(const Cell& cell, std::uint32_t object,
                                                       const std::vector<Site>& sites) const {
    Sites result{{Site::object(object), here}};
    for (const Site& site : sites) result.push_back(site_in(cell, site));
    return result;
}

// The smallest object may be there in several images; the least of them counts, whatever all are moved by.
VoidNetworkBuilder::Seen VoidNetworkBuilder::seen_from_smallest(Sites sites) {
    std::ranges::sort(sites);
    const Image by = sites.front().image;
    move_back(sites, by);
    return {std::move(sites), by};
}

void VoidNetworkBuilder::add(std::uint32_t object, const Cell& cell) try {
    has_cell_[object] = true;
    add_vertices_and_edges(object, cell);
} catch (const UndecidedError& e) {
    if (undecided_.empty()) undecided_ = e.what();
}

void VoidNetworkBuilder::add_vertices_and_edges(std::uint32_t object, const Cell& cell) {
    std::vector<std::uint32_t> sights(cell.vertices.size(), UINT32_MAX);
    for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
        const CellVertex& v = cell.vertices[i];
        const auto balls = std::ranges::count_if(v.sites, [](const Site& s) { return s.is_object(); });
        if (balls < 2) continue;
        Seen seen = seen_from_smallest(sites_in(cell, object, {v.sites.begin(), v.sites.end()}));
        const NetworkSite self{Site::object(object), minus(here, seen.by)};
        const auto owner = std::ranges::find(seen.sites, self) - seen.sites.begin();
        sights[i] = static_cast<std::uint32_t>(sights_.size());
        // The place as seen from the smallest site: moving rounds each coordinate once.
        const Vec3 shift = decided_->shift(seen.by);
        const Vec3 point = v.point - shift;
        const double rounding =
            seen.by == here ? 0 : std::numeric_limits<double>::epsilon() * point.cwiseAbs().sum();
        vertices_[std::move(seen.sites)].push_back(sights[i]);
        sights_.push_back({static_cast<std::uint32_t>(owner), seen.by, point, v.radius,
                           Interval::up(v.error + rounding), v.is_touching});
    }
    for (const CellEdge& edge : cell.edges) add_edge(object, cell, edge, sights);
}

void VoidNetworkBuilder::add_edge(std::uint32_t object, const Cell& cell, const CellEdge& edge,
                                  const std::vector<std::uint32_t>& sights) {
    std::vector<Site> sites(edge.sites.begin(), edge.sites.end());
    sites.insert(sites.end(), edge.extra_sites.begin(), edge.extra_sites.end());
    if (!std::ranges::all_of(sites, [](const Site& s) { return s.is_object(); })) return;
    Seen seen = seen_from_smallest(sites_in(cell, object, sites));
    const NetworkSite self{Site::object(object), minus(here, seen.by)};
    const auto owner = static_cast<std::size_t>(std::ranges::find(seen.sites, self) - seen.sites.begin());
    ArcCount& count = edges_[seen.sites];
    count.of_owner.resize(seen.sites.size());
    ++count.of_owner[owner];
    if (owner != 0) return;

    Arc arc;
    arc.edge.sites = std::move(seen.sites);
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

// Of a set of sites with one vertex all sights are of that one. Of others each is of the only one that its
// error and theirs leave.
void VoidNetworkBuilder::find_vertices(VoidNetwork& network) {
    for (auto& [sites, sights] : vertices_) {
        std::vector<std::vector<std::uint32_t>> of_owner(sites.size());
        for (const std::uint32_t s : sights) of_owner[sights_[s].owner].push_back(s);
        const std::vector<std::uint32_t>& own = of_owner[0];
        const auto first = static_cast<std::uint32_t>(network.vertices.size());
        // Errors of touching vertices do not bound places.
        const bool are_apart = std::ranges::none_of(sights, [&](auto s) { return sights_[s].is_touching; });
        for (const std::uint32_t s : own) {
            Sight& sight = sights_[s];
            sight.vertex = static_cast<std::uint32_t>(network.vertices.size());
            network.vertices.push_back({sight.point, sight.clearance, sight.error, sites, sight.is_touching});
        }
        for (std::size_t o = 1; o < sites.size(); ++o) {
            if (!sites[o].site.is_object()) continue;
            if (of_owner[o].size() != own.size())
                throw UndecidedError("void network: cells do not agree about vertices of objects " +
                                     names_of(sites));
            std::vector<bool> is_taken(own.size(), false);
            for (const std::uint32_t s : of_owner[o]) {
                Sight& sight = sights_[s];
                std::size_t possible = 0, which = 0;
                for (std::size_t k = 0; k < own.size(); ++k) {
                    const NetworkVertex& v = network.vertices[first + k];
                    const double distance = (sight.point - v.point).norm(),
                                 doubt = sight.error + v.error +
                                         4 * std::numeric_limits<double>::epsilon() *
                                             (sight.point.cwiseAbs().sum() + v.point.cwiseAbs().sum());
                    if (own.size() > 1 && are_apart && distance > doubt) continue;
                    ++possible;
                    which = k;
                }
                if (possible != 1 || is_taken[which])
                    throw UndecidedError("void network: errors do not tell apart the vertices of objects " +
                                         names_of(sites));
                is_taken[which] = true;
                sight.vertex = first + static_cast<std::uint32_t>(which);
            }
        }
    }
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
                std::ranges::sort(edge.sites);
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
