#include "network_edges.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "../../core/errors.hpp"

namespace vcell::whole {

namespace {

std::vector<Site> sites_of(const CellEdge& edge) {
    std::vector<Site> sites(edge.sites.begin(), edge.sites.end());
    sites.insert(sites.end(), edge.extra_sites.begin(), edge.extra_sites.end());
    return sites;
}

bool is_sight(std::uint32_t end) { return end < NetworkVertices::at_cut; }

}  // namespace

FollowedArcs NetworkEdges::add(std::uint32_t object, const Cell& cell,
                               const std::vector<std::uint32_t>& sights,
                               const std::function<bool(const NetworkSites&)>& is_followed) {
    const NetworkSite self{Site::object(object), here};
    const auto is_ball = [&](const NetworkSite& s) { return names_.decided().is_ball(s.site.index); };
    FollowedArcs followed;
    for (std::uint32_t i = 0; i < cell.edges.size(); ++i) {
        const CellEdge& edge = cell.edges[i];
        const std::vector<Site> own_sites = sites_of(edge);
        if (!std::ranges::all_of(own_sites, [](const Site& s) { return s.is_object(); })) continue;
        std::array<std::uint32_t, 2> ends{NetworkVertices::none, NetworkVertices::none};
        if (!edge.vertices.empty()) {
            ends = {sights[edge.vertices.front()], sights[edge.vertices.back()]};
            if (std::ranges::max(ends) == NetworkVertices::none)
                throw InternalError("void network: an edge of three objects ends where two are");
        }
        NetworkSites sites = names_.sites_in(cell, object, own_sites);
        if (!std::ranges::all_of(sites, is_ball))
            for (const std::uint32_t end : ends)
                if (is_sight(end)) ends_.push_back({end, sites});
        SiteNames::Owned owned = names_.seen_from_owner(sites);
        const bool is_cut = !is_ball(owned.owner), is_owned = is_cut && owned.owner == self;
        if (is_owned || is_followed(sites)) {
            followed.of_edge[i] = static_cast<std::uint32_t>(followed.arcs.size());
            followed.is_owned.push_back(is_owned);
            CutArc& arc = followed.arcs.emplace_back(&edge, std::move(sites));
            for (const std::size_t k : {0, 1})
                if (is_sight(ends[k])) arc.vertices[k] = ends[k];
        }
        if (is_ball(self)) add_owned(object, cell, edge, std::move(owned), ends);
    }
    if (!followed.arcs.empty()) followed.edges = join_arcs(names_.decided(), object, cell, followed.arcs);
    for (const JoinedArcs& joined : followed.edges)
        if (followed.is_owned[joined.arcs.front()]) add_joined(object, cell, followed, joined);
    return followed;
}

// An edge that a ball owns, as one of its balls has it.
void NetworkEdges::add_owned(std::uint32_t object, const Cell& cell, const CellEdge& edge,
                             SiteNames::Owned owned, const std::array<std::uint32_t, 2>& ends) {
    ArcCount& count = edges_[owned.sites];
    count.of_ball.resize(owned.sites.size());
    const NetworkSite self{Site::object(object), minus(here, owned.owner.image)};
    ++count.of_ball[static_cast<std::size_t>(std::ranges::find(owned.sites, self) - owned.sites.begin())];
    if (owned.owner != NetworkSite{Site::object(object), here}) return;
    Arc& arc = count.arcs.emplace_back();
    if (!edge.vertices.empty()) arc.ends = ends;
    arc.edge.sites = std::move(owned.sites);
    arc.edge.length = edge.length;
    arc.edge.length_error = edge.length_error;
    const Interval least = bottleneck(object, cell, edge);
    arc.edge.bottleneck = least.mid();
    arc.edge.bottleneck_error = least.radius();
}

// An edge between tubes and planes.
void NetworkEdges::add_joined(std::uint32_t object, const Cell& cell, const FollowedArcs& followed,
                              const JoinedArcs& joined) {
    constexpr double u = std::numeric_limits<double>::epsilon();
    Arc arc;
    NetworkEdge& edge = arc.edge;
    arc.ends = joined.vertices;
    edge.image = joined.image;
    edge.sites = followed.arcs[joined.arcs.front()].sites;
    std::optional<Extremes> range;
    for (const std::uint32_t a : joined.arcs) {
        const CellEdge& part = *followed.arcs[a].edge;
        const Extremes more = clearance(object, cell, part);
        range = range ? united(*range, more) : more;
        edge.length += part.length;
        edge.length_error += part.length_error + u * edge.length;
    }
    if (const std::optional<Interval>& between = joined.clearance_between)
        range = united(*range, {*between, *between});
    edge.length += joined.length_between.mid();
    edge.length_error += joined.length_between.radius() + u * edge.length;
    edge.bottleneck = range->least.mid();
    edge.bottleneck_error = range->least.radius();
    if (!joined.vertices && edge.winds()) {
        const CellEdge& first = *followed.arcs[joined.arcs.front()].edge;
        arc.point = first.curve.evaluate(first.curve.domain_begin());
        arc.error = first.error;
        edge.widest = range->greatest.mid();
        edge.widest_error = range->greatest.radius();
        // Either sense is as good.
        if (edge.image < here) edge.image = minus(here, edge.image);
    }
    edges_[edge.sites].arcs.push_back(std::move(arc));
}

Extremes NetworkEdges::clearance(std::uint32_t object, const Cell& cell, const CellEdge& edge) const {
    return clearance_along(
        {&names_.object(object), &names_.object(cell, edge.sites[0]), &names_.object(cell, edge.sites[1])},
        edge.curve, edge.error);
}

Interval NetworkEdges::bottleneck(std::uint32_t object, const Cell& cell, const CellEdge& edge) const {
    const std::vector<Site> sites = sites_of(edge);
    const auto is_ball = [&](const Site& s) {
        return std::holds_alternative<Sphere>(names_.object(cell, s));
    };
    if (!std::ranges::all_of(sites, is_ball)) return clearance(object, cell, edge).least;
    const auto ball_in = [&](const Site& s) { return std::get<Sphere>(names_.object(cell, s)); };
    constexpr double u = std::numeric_limits<double>::epsilon();
    const Sphere& self = names_.decided().ball(object);
    // Bounds a handful of operations on coordinates as large as the point's.
    const auto rounding = [&](const Vec3& p) {
        return 16 * u * (p.cwiseAbs().sum() + self.center.cwiseAbs().sum() + self.radius);
    };
    EdgeArc arc;
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
            if (const auto least = least_clearance({self, ball_in(sites[a]), ball_in(sites[b])}, arc))
                return *least;
    throw UndecidedError("void network: the least clearance along an edge of object " +
                         std::to_string(object) + " could not be enclosed");
}

// Do all cells of a vertex's objects have the same edges there? Of balls alone they are counted as a whole.
void NetworkEdges::require_same_ends() const {
    std::map<std::pair<std::uint32_t, NetworkSites>, std::map<NetworkSite, int>> found;
    for (const ArcEnd& end : ends_) {
        const NetworkVertices::Sight& a = vertices_.sight(end.sight);
        const NetworkSite cell = names_.representative({Site::object(a.cell), minus(here, a.by)});
        ++found[{a.vertex, names_.seen_from(end.sites, a.by)}][cell];
    }
    for (const auto& [edge, counts] : found)
        for (const NetworkSite& site : edge.second) {
            if (vertices_.cells(site.site.index) == 0) continue;
            const auto count = counts.find(site);
            if (count == counts.end() || count->second != counts.begin()->second)
                throw UndecidedError("void network: cells do not agree about edges of objects " +
                                     names_of(edge.second));
        }
}

void NetworkEdges::find(std::vector<NetworkEdge>& edges) {
    require_same_ends();
    for (auto& [sites, count] : edges_) {
        std::optional<std::uint32_t> same;
        for (std::size_t k = 0; k < count.of_ball.size(); ++k) {
            if (!names_.decided().is_ball(sites[k].site.index)) continue;
            if (same.value_or(count.of_ball[k]) != count.of_ball[k])
                throw UndecidedError("void network: cells do not agree about edges of objects " +
                                     names_of(sites));
            same = count.of_ball[k];
        }
        for (Arc& arc : count.arcs) {
            arc.number = static_cast<std::uint32_t>(edges.size());
            NetworkEdge edge = arc.edge;
            if (arc.ends) {
                const NetworkVertices::Sight &a = vertices_.sight((*arc.ends)[0]),
                                             &b = vertices_.sight((*arc.ends)[1]);
                edge.vertices = {a.vertex, b.vertex};
                edge.image = minus(plus(b.by, edge.image), a.by);
                edge.sites = names_.seen_from(std::move(edge.sites), a.by);
            }
            edges.push_back(std::move(edge));
        }
    }
}

std::optional<NetworkEdges::Line> NetworkEdges::line_through(const NetworkSites& sites, const Vec3& point,
                                                             double error) const {
    const SiteNames::Owned owned = names_.seen_from_owner(sites);
    const auto edges = edges_.find(owned.sites);
    if (edges == edges_.end()) return std::nullopt;
    const Lattice& lattice = names_.decided().lattice();
    const Vec3 as_seen = point - lattice.shift(owned.owner.image);
    std::optional<Line> found;
    for (const Arc& arc : edges->second.arcs) {
        if (!arc.edge.winds()) continue;
        const Vec3 along = lattice.shift(arc.edge.image).normalized();
        const double rounding = 0x1p-46 * (point.cwiseAbs().sum() + arc.point.cwiseAbs().sum());
        if ((as_seen - arc.point).cross(along).norm() > error + arc.error + rounding) continue;
        if (found)
            throw UndecidedError("void network: edges of objects " + names_of(sites) +
                                 " that wind are not told from each other");
        found = Line{arc.number, owned.owner.image};
    }
    return found;
}

}  // namespace vcell::whole
