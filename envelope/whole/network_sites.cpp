#include "network_sites.hpp"

#include <algorithm>
#include <utility>

#include "../object_distance.hpp"

namespace vcell::whole {

namespace {

// Whose cells are taken first: those of balls are whole. Vessels have none.
enum class Rank : std::uint8_t { Ball, Tube, Plane, Vessel };

Rank rank_of(const Object& object) {
    if (std::holds_alternative<Sphere>(object)) return Rank::Ball;
    if (std::holds_alternative<Cylinder>(object)) return Rank::Tube;
    return std::holds_alternative<Plane>(object) ? Rank::Plane : Rank::Vessel;
}

}  // namespace

Object SiteNames::object(const NetworkSite& site) const {
    Object moved = object(site.site.index);
    place_of(moved) += decided_.lattice().shift(site.image);
    return moved;
}

const Object& SiteNames::object(const Cell& cell, const Site& site) const {
    return cell.scene.images.empty() ? object(site.index) : cell.scene.objects[site.index];
}

NetworkSite SiteNames::representative(NetworkSite site) const {
    if (site.site.is_object())
        site.image = whole::representative(site.image, decided_.periods(site.site.index));
    return site;
}

NetworkSite SiteNames::site_in(const Cell& cell, const Site& site) const {
    return representative(site_in_diagram(cell, side_at_end(cell.scene, site)));
}

NetworkSites SiteNames::sites_in(const Cell& cell, std::uint32_t object,
                                 const std::vector<Site>& sites) const {
    NetworkSites result{{Site::object(object), here}};
    for (const Site& site : sites) result.push_back(site_in(cell, site));
    std::ranges::sort(result);
    result.erase(std::ranges::unique(result).begin(), result.end());
    return result;
}

NetworkSites SiteNames::seen_from(NetworkSites sites, const Image& image) const {
    for (NetworkSite& s : sites)
        if (s.site.is_object()) s = representative({s.site, minus(s.image, image)});
    std::ranges::sort(sites);
    return sites;
}

SiteNames::Owned SiteNames::seen_from_owner(const NetworkSites& sites) const {
    const auto rank = [&](const NetworkSite& s) {
        return std::pair(rank_of(object(s.site.index)), s.site.index);
    };
    const std::uint32_t owner = std::ranges::min_element(sites, {}, rank)->site.index;
    Owned result;
    for (const NetworkSite& s : sites) {
        if (s.site.index != owner) continue;
        // If several images of it are there, one of them sees the greatest list, wherever it is seen from.
        NetworkSites seen = seen_from(sites, s.image);
        if (!result.sites.empty() && !(result.sites < seen)) continue;
        result = {std::move(seen), s};
    }
    return result;
}

}  // namespace vcell::whole
