#include "network_vertices.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "../../core/errors.hpp"
#include "joined_arcs.hpp"

namespace vcell::whole {

std::vector<std::uint32_t> NetworkVertices::add(std::uint32_t object, const Cell& cell) {
    std::vector<std::uint32_t> sights(cell.vertices.size(), none);
    if (++cells_[object] == 1) sights_of_[object][0] = static_cast<std::uint32_t>(sights_.size());
    for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
        const CellVertex& v = cell.vertices[i];
        if (std::ranges::count_if(v.sites, [](const Site& s) { return s.is_object(); }) < 2) continue;
        NetworkSites sites = names_.sites_in(cell, object, {v.sites.begin(), v.sites.end()});
        if (std::ranges::any_of(sites,
                                [&](const NetworkSite& s) { return is_cut(names_.decided(), s.site); })) {
            sights[i] = at_cut;
            continue;
        }
        sights[i] = static_cast<std::uint32_t>(sights_.size());
        sights_.push_back({object, std::move(sites), v.point, v.radius, v.error, v.is_touching});
    }
    sights_of_[object][1] = static_cast<std::uint32_t>(sights_.size());
    return sights;
}

// Where b's cell is as seen from a's, if both have a vertex there: that is an image of the site, of a tube or
// a plane the one whose period b is in.
Image NetworkVertices::image_of(const Sight& a, const Sight& b, const NetworkSite& site) const {
    const std::span<const Image> periods = names_.decided().periods(site.site.index);
    if (periods.empty()) return site.image;
    const Lattice& lattice = names_.decided().lattice();
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> moves(3, periods.size());
    for (std::size_t k = 0; k < periods.size(); ++k)
        moves.col(static_cast<Eigen::Index>(k)) = lattice.shift(periods[k]);
    const Vec3 off = a.point - b.point - lattice.shift(site.image);
    const Eigen::VectorXd times = (moves.transpose() * moves).llt().solve(moves.transpose() * off);
    Image image = site.image;
    for (std::size_t k = 0; k < periods.size(); ++k)
        image = plus(image, periods[k], static_cast<int>(std::lround(times[static_cast<Eigen::Index>(k)])));
    return image;
}

// Do the errors tell that b, of a cell that is at `image` of a's, is another vertex than a? Those of touching
// vertices bound no places.
bool NetworkVertices::are_apart(const Sight& a, const Sight& b, const Image& image) const {
    const Vec3 other = b.point + names_.decided().lattice().shift(image);
    const double rounding = 8 * std::numeric_limits<double>::epsilon() *
                            (a.point.cwiseAbs().sum() + b.point.cwiseAbs().sum() + other.cwiseAbs().sum());
    return !a.is_touching && !b.is_touching && (a.point - other).norm() > a.error + b.error + rounding;
}

// The vertex as the cell of one of its sites has it: that cell has it, as the site ties there. It is the one
// of the same sites, or, where these are of two vertices or where a cell leaves some out, the one that is not
// apart. Objects that a cell meets in a vertex alone may have been left out of it, as they own nothing there.
NetworkVertices::OtherSight NetworkVertices::sight_of(const Sight& sight, const NetworkSite& site) const {
    const auto has_same_sites = [&](const Sight& other, const Image& image) {
        return std::ranges::all_of(other.sites, [&](NetworkSite s) {
            if (s.site.is_object()) s = names_.representative({s.site, plus(s.image, image)});
            return std::ranges::binary_search(sight.sites, s);
        });
    };
    const auto [from, to] = sights_of_[site.site.index];
    const std::span<const std::uint32_t> all(by_objects_.data() + from, by_objects_.data() + to);
    const auto same_objects = std::ranges::equal_range(
        all, sight, has_lesser_objects, [&](std::uint32_t s) -> const Sight& { return sights_[s]; });
    for (const bool is_by_sites : {true, false}) {
        std::optional<OtherSight> found, last;
        std::uint32_t count = 0, left = 0;
        for (const std::uint32_t s : is_by_sites ? std::span(same_objects) : all) {
            const Image image = image_of(sight, sights_[s], site);
            if (is_by_sites && !has_same_sites(sights_[s], image)) continue;
            ++count;
            last = {s, image};
            if (are_apart(sight, sights_[s], image)) continue;
            ++left;
            found = last;
        }
        if (is_by_sites && count == 1) return *last;
        if (left == 1) return *found;
        if (count > 0 && is_by_sites) break;
    }
    throw UndecidedError("void network: the vertex of objects " + names_of(sight.sites) +
                         " is not told from others in the cell of object " + to_string(site.site));
}

// A vertex, found from one cell's sight of it; all cells' sights are told its number.
NetworkVertex NetworkVertices::vertex_of(std::uint32_t sight, std::uint32_t number) {
    // Where the cells are that have it, as seen from the first; and sites that have no cells.
    std::map<NetworkSite, OtherSight> seen{{{Site::object(sights_[sight].cell), here}, {sight, here}}};
    std::vector<OtherSight> waiting{{sight, here}};
    NetworkSites others;
    while (!waiting.empty()) {
        const OtherSight at = waiting.back();
        waiting.pop_back();
        const Sight& a = sights_[at.sight];
        for (const NetworkSite& site : a.sites) {
            if (!site.site.is_object()) {
                others.push_back(site);
                continue;
            }
            const NetworkSite there = names_.representative({site.site, plus(at.image, site.image)});
            if (cells_[site.site.index] == 0) {
                others.push_back(there);
                continue;
            }
            if (seen.contains(there)) continue;
            const OtherSight other = sight_of(a, site);
            waiting.push_back({other.sight, plus(at.image, other.image)});
            seen.emplace(there, waiting.back());
        }
    }
    const OtherSight& first = seen.begin()->second;
    NetworkVertex vertex;
    for (const auto& [site, at] : seen) {
        others.push_back(site);
        Sight& a = sights_[at.sight];
        if (std::exchange(a.vertex, number) != UINT32_MAX)
            throw UndecidedError("void network: two vertices of objects " + names_of(a.sites) +
                                 " are the same one in the cell of object " + std::to_string(a.cell));
        a.by = minus(first.image, at.image);
    }
    vertex.sites = names_.seen_from(std::move(others), first.image);
    vertex.sites.erase(std::ranges::unique(vertex.sites).begin(), vertex.sites.end());
    const Sight& own = sights_[first.sight];
    vertex.point = own.point;
    vertex.clearance = own.clearance;
    vertex.error = own.error;
    vertex.is_touching = own.is_touching;
    return vertex;
}

// Sites ascend by their objects first, which are the same ones in all cells.
bool NetworkVertices::has_lesser_objects(const Sight& a, const Sight& b) {
    return std::ranges::lexicographical_compare(a.sites, b.sites, {}, &NetworkSite::site, &NetworkSite::site);
}

void NetworkVertices::find(std::vector<NetworkVertex>& vertices) {
    by_objects_.resize(sights_.size());
    std::iota(by_objects_.begin(), by_objects_.end(), 0u);
    for (const auto& [from, to] : sights_of_)
        std::ranges::stable_sort(std::span(by_objects_.data() + from, by_objects_.data() + to),
                                 has_lesser_objects,
                                 [&](std::uint32_t s) -> const Sight& { return sights_[s]; });
    for (std::uint32_t s = 0; s < sights_.size(); ++s)
        if (sights_[s].vertex == UINT32_MAX)
            vertices.push_back(vertex_of(s, static_cast<std::uint32_t>(vertices.size())));
    std::vector<std::uint32_t> order(vertices.size()), place(order.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {},
                             [&](std::uint32_t i) -> const NetworkSites& { return vertices[i].sites; });
    std::vector<NetworkVertex> sorted;
    sorted.reserve(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        place[order[i]] = i;
        sorted.push_back(std::move(vertices[order[i]]));
    }
    vertices = std::move(sorted);
    for (Sight& sight : sights_) sight.vertex = place[sight.vertex];
}

}  // namespace vcell::whole
