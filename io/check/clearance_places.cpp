#include "clearance_places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace vcell::check {
namespace {

std::vector<Site> sites_of(const CellFace& f) {
    std::vector<Site> sites{f.site};
    sites.insert(sites.end(), f.extra_sites.begin(), f.extra_sites.end());
    std::ranges::sort(sites);
    return sites;
}

class ClearancePlaceRoom : public Room {
public:
    using Room::Room;

    /// Has the part of the cell an element that the place may be on?
    bool has(const ClearancePlace& place) const {
        const auto holds = [](const std::vector<std::uint32_t>& all, std::uint32_t one) {
            return std::ranges::binary_search(all, one);
        };
        if (place.vertex) return holds(subject_.vertices, *place.vertex) && has_sites_of_vertex(place);
        if (place.edge) return holds(subject_.edges, *place.edge) && label(*place.edge) == place.sites;
        return std::ranges::any_of(subject_.faces, [&](std::uint32_t f) {
            return place.face.value_or(f) == f && sites_of(cell_.faces[f]) == place.sites;
        });
    }

    void judge(const char* where, const ClearancePlace& place) {
        if (const auto what = contradiction(place.point, place.error, place.sites)) return note(where, *what);
        const double away = height(place.point);
        if (std::abs(away - place.clearance) > 2 * place.error + rounding())
            note(where, fmt::format("is {:.3g} from the base", away));
    }

private:
    bool has_sites_of_vertex(const ClearancePlace& place) const {
        return std::ranges::equal(cell_.vertices[*place.vertex].sites, place.sites);
    }
};

bool is_sound(const ClearancePlace& place) {
    const auto is_bound = [](double x) { return x >= 0 && std::isfinite(x); };
    const int named = (place.vertex ? 1 : 0) + (place.edge ? 1 : 0) + (place.face ? 1 : 0);
    return place.point.allFinite() && is_bound(place.error) && is_bound(place.clearance_error) && named <= 1;
}

}  // namespace

void certify_clearance_places(std::span<const Subject> subjects, const CheckOptions& options,
                              Certificate& certificate) {
    const std::optional<ClearancePlaces>& places = subjects.front().cell.clearance_places;
    if (!places) return;
    const auto judge = [&](const char* where, const ClearancePlace& place) {
        if (!is_sound(place))
            return certificate.refute(where,
                                      "is not finite, has an error that is none, or names two elements");
        for (const Subject& subject : subjects) {
            ClearancePlaceRoom room(subject, options, certificate);
            if (room.has(place)) return room.judge(where, place);
        }
        certificate.refute(where, "has not the sites of the element that it names");
    };
    if (places->least) judge("measures.min_clearance_place", *places->least);
    if (places->greatest) judge("measures.max_clearance_place", *places->greatest);
}

}  // namespace vcell::check
