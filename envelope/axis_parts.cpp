#include "axis_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vcell {

std::array<double, 2> AxisParts::range(const Box& box, const BaseFrame& frame) {
    std::array<double, 2> range{infinity, -infinity};
    for (unsigned corner = 0; corner < 8; ++corner) {
        const auto coordinate = [&](unsigned axis) {
            return ((corner & 1u << axis) != 0 ? box.max : box.min)[axis];
        };
        const double y = frame.to_canonical({coordinate(0), coordinate(1), coordinate(2)}).y();
        range = {std::min(range[0], y), std::max(range[1], y)};
    }
    const bool ends_with_sides = std::ranges::any_of(canonical_box(box, frame), is_across);
    const double more = ends_with_sides ? 0 : 0x1p-10 * (range[1] - range[0]);
    return {range[0] - more, range[1] + more};
}

AxisParts::AxisParts(const Box& box, const BaseFrame& frame) : sides_(canonical_box(box, frame)) {
    const std::array<double, 2> range = AxisParts::range(box, frame);
    ends_ = {{range[0], 0}, {range[1], 0}};
    for (const BoxSide& side : sides_)
        if (side.m.y() != 0 && !is_across(side))
            ends_.push_back({side.k / side.m.y(), 1 / std::abs(side.m.y())});
    std::ranges::sort(ends_, {}, &End::y);
    for (std::size_t i = 0; i + 1 < ends_.size(); ++i)
        if (ends_[i].y >= range[0] && ends_[i + 1].y <= range[1] && ends_[i].y < ends_[i + 1].y)
            parts_.push_back({ends_[i].y, ends_[i + 1].y});
}

std::array<double, 2> AxisParts::clear_of_planes(const std::array<double, 2>& part, double room) const {
    const double middle = 0.5 * part[0] + 0.5 * part[1];
    std::array<double, 2> stretch = part;
    for (const End& end : ends_) {
        if (end.y < middle)
            stretch[0] = std::max(stretch[0], end.y + room * end.slant);
        else
            stretch[1] = std::min(stretch[1], end.y - room * end.slant);
    }
    return stretch;
}

std::array<bool, 6> AxisParts::beyond(const std::array<double, 2>& part) const {
    const double middle = 0.5 * (part[0] + part[1]);
    std::array<bool, 6> beyond{};
    for (const BoxSide& side : sides_) beyond[side.index] = !is_across(side) && side.k < side.m.y() * middle;
    return beyond;
}

}  // namespace vcell
