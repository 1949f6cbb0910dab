#include "room.hpp"

#include <cmath>

#include "containment.hpp"

namespace vcell::check {

void Room::rivals(const Vec3& p, double reach, std::span<const Condition> own,
                  std::vector<Condition>& found) const {
    found.clear();
    const auto add = [&](const Site& site) {
        const auto is_own = [&](const Condition& o) { return o.site == site && !o.at_rim; };
        if (std::ranges::any_of(own, is_own)) return;
        space().for_conditions(site, [&](const Condition& c) { found.push_back(c); });
    };
    near_.clear();
    subject_.tree.near(p, reach, near_);
    for (const std::uint32_t k : near_) add(Site::object(k));
    for (std::uint32_t s = 0; s < 6; ++s)
        if (!geometry_.is_end(s)) add(Site::box_side(s));
    for (std::uint32_t e = 0; geometry_.is_cylinder() && e < 2; ++e) add(Site::end(e));
}

bool Room::is_held(const Site& site, std::span<const Condition> own) const {
    if (site.kind == Site::Kind::BoxSide)
        return std::ranges::any_of(own, [&](const Condition& c) {
            return c.site.is_object() && contains_mirrored(scene_.objects[c.site.index], scene_, site.index);
        });
    if (!site.is_object()) return false;
    const Object& object = scene_.objects[site.index];
    return base_contains(scene_.base, object) || std::ranges::any_of(own, [&](const Condition& c) {
               if (c.site.kind == Site::Kind::BoxSide && !c.at_rim)
                   return mirrored_contains(scene_, c.site.index, object);
               if (!c.site.is_object()) return false;
               const Object& holder = scene_.objects[c.site.index];
               const auto* plane = std::get_if<Plane>(&holder);
               return contains(holder, object) || (plane && is_across(*plane, scene_, object));
           });
}

std::optional<std::string> Room::contradiction(const Vec3& p, double error,
                                               std::span<const Site> sites) const {
    const double r = height(p);
    for (const Site& s : sites) {
        const double e = geometry_.excess(s, p, r);
        // Along a base plane's rim a side of the box is met by the point below.
        const bool is_rim = s.kind == Site::Kind::BoxSide && sites.size() > 1 && !cell_.is_complete;
        const double limit = 2 * error + geometry_.site_rounding(s);
        if (is_rim && geometry_.distance_from_rim(s, p) <= limit) continue;
        // Moving p by `error` changes both distances by that much.
        if (std::abs(e) > limit)
            return fmt::format("{} is {:.3g} {} than the base", title(s), std::abs(e),
                               e > 0 ? "farther" : "nearer");
    }
    if (r < geometry_.least_height() - error - rounding())
        return fmt::format("lies {:.3g} below the base", -r);
    if (const double out = -geometry_.inside_box(p); out > error + rounding())
        return fmt::format("lies {:.3g} outside the box", out);
    if (const auto i = geometry_.nearer(p, r - 2 * error))
        return fmt::format("object {} is {:.3g} nearer than the base", *i, r - geometry_.distance_to(*i, p));
    return std::nullopt;
}

}  // namespace vcell::check
