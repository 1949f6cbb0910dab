#include "room.hpp"

#include <cmath>

namespace vcell::check {

std::optional<std::string> Room::contradiction(const Vec3& p, double error, std::span<const Site> sites) const {
    const double r = height(p);
    for (const Site& s : sites) {
        const double e = geometry_.excess(s, p, r);
        // Moving p by `error` changes both distances by that much.
        if (std::abs(e) > 2 * error + geometry_.site_rounding(s))
            return fmt::format("{} is {:.3g} {} than the base", title(s), std::abs(e),
                               e > 0 ? "farther" : "nearer");
    }
    if (r < geometry_.least_height() - error - rounding())
        return fmt::format("lies {:.3g} below the base", -r);
    if (const double out = -geometry_.inside_box(p); out > error + rounding())
        return fmt::format("lies {:.3g} outside the box", out);
    if (const auto i = geometry_.nearer(p, r - 2 * error))
        return fmt::format("object {} is {:.3g} nearer than the base", *i,
                           r - geometry_.distance_to(*i, p));
    return std::nullopt;
}

}  // namespace vcell::check
