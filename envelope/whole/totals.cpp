#include "totals.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "own_periods.hpp"

namespace vcell::whole {

namespace {

std::string name_of(std::uint32_t object, const Image& image) {
    std::string text = std::to_string(object);
    if (image != Image{0, 0, 0})
        text += " (" + std::to_string(image[0]) + ", " + std::to_string(image[1]) + ", " +
                std::to_string(image[2]) + ")";
    return text;
}

}  // namespace

ContactSide contact_side(std::uint32_t owner, const CellContact& c, std::span<const ObjectImage> periods) {
    ContactSide side{owner, c.site, c.image, owner, c.faces, c.area, c.area_error};
    if (!c.site.is_object()) return side;
    std::vector<Image> both;
    for (const std::uint32_t object : {std::min(owner, c.site.index), std::max(owner, c.site.index)})
        for (const ObjectImage& p : std::ranges::equal_range(periods, object, {}, &ObjectImage::number))
            both.push_back(p.image);
    const Image back =
        representative({static_cast<std::int16_t>(-c.image[0]), static_cast<std::int16_t>(-c.image[1]),
                        static_cast<std::int16_t>(-c.image[2])},
                       both);
    side.image = representative(c.image, both);
    if (std::pair(c.site.index, side.image) < std::pair(owner, back)) {
        side.first = c.site.index;
        side.second = Site::object(owner);
        side.image = back;
    }
    return side;
}

bool knows_contacts(const DiagramCell& cell) {
    return cell.state == DiagramCell::State::Computed && !cell.is_estimated &&
           cell.volume > cell.volume_error;
}

ContactTable pair_up(std::vector<ContactSide> sides, const std::function<bool(std::uint32_t)>& is_known) {
    const auto key = [](const ContactSide& s) { return std::tie(s.first, s.second, s.image); };
    std::ranges::sort(sides, [&](const ContactSide& a, const ContactSide& b) {
        return std::tuple_cat(key(a), std::tie(a.owner)) < std::tuple_cat(key(b), std::tie(b.owner));
    });

    ContactTable table;
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && key(sides[end]) == key(sides[i])) ++end;
        const ContactSide& one = sides[i];
        Contact pair{one.first, one.second, one.image, one.faces, one.area, one.area_error};
        const std::string title =
            "objects " + name_of(one.first, {0, 0, 0}) + " and " +
            (one.second.is_object() ? name_of(one.second.index, one.image) : to_string(one.second));
        if (end - i > 1) {
            const ContactSide& other = sides[i + 1];
            // What both enclose.
            const double low = std::max(one.area - one.area_error, other.area - other.area_error),
                         high = std::min(one.area + one.area_error, other.area + other.area_error);
            if (low > high || (one.faces != other.faces && one.faces != 0 && other.faces != 0)) {
                table.faults.push_back(title + ": the two cells do not have the same faces");
            } else {
                pair.area = 0.5 * low + 0.5 * high;
                pair.area_error = 0.5 * (high - low) + std::numeric_limits<double>::epsilon() * high;
            }
        } else if (one.second.is_object()) {
            const std::uint32_t other = one.owner == one.first ? one.second.index : one.first;
            if (!(one.area <= one.area_error) && is_known(other))
                table.faults.push_back(title + ": only the cell of " + std::to_string(one.owner) +
                                       " has faces between them");
        }
        table.contacts.push_back(pair);
        i = end;
    }
    return table;
}

VolumeSum::VolumeSum(const DiagramScene& scene, double moved) {
    const Vec3 size = scene.box.max - scene.box.min;
    so_far.box = size.prod();
    // The sides of a box in doubles, their product, and what periodic ones were moved by.
    so_far.error = 4 * std::numeric_limits<double>::epsilon() * so_far.box;
    for (int i = 0; i < 3; ++i)
        if (scene.periodic[i]) so_far.error += 2 * moved * so_far.box / size[i];
}

void VolumeSum::add(std::span<const DiagramCell> cells) {
    for (const DiagramCell& cell : cells) {
        if (cell.state != DiagramCell::State::Computed) continue;
        so_far.volume += cell.volume;
        so_far.error += cell.volume_error;
        so_far.is_estimated = so_far.is_estimated || cell.is_estimated;
    }
}

FilledVolume VolumeSum::of(std::size_t cells) const {
    FilledVolume sum = so_far;
    sum.error += std::numeric_limits<double>::epsilon() * static_cast<double>(cells) * sum.volume;
    return sum;
}

}  // namespace vcell::whole
