#include "axis_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "object_distance.hpp"

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

// A vessel's distance along a line is concave: from its greatest value to 0 it falls no faster than there.
AxisParts::Within AxisParts::within_vessels(const Scene& scene, const Cylinder& base, const BaseFrame& frame,
                                            const std::array<double, 2>& range) {
    constexpr int enough = 200;          // thirds, or halves, of a range
    constexpr double certain = 0x1p-40;  // far more than rounding
    Within within;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        const Object& vessel = scene.objects[i];
        if (!is_vessel(vessel) || !scene.competes(i)) continue;
        const auto room = [&](double y) {
            const Vec3 p = frame.to_world({0, y, 0});
            return distance_from(vessel, p) + base.radius + certain * (scene.box.diagonal() + p.norm());
        };
        double low = range[0], high = range[1];
        for (int k = 0; k < enough; ++k) {
            const double third = (high - low) / 3, a = low + third, b = high - third;
            if (room(a) < room(b))
                low = a;
            else
                high = b;
        }
        const double inside = 0.5 * (low + high), most = room(inside);
        if (!(most > 0)) {
            within.ends = {range[1], range[0]};
            return within;
        }
        for (const std::size_t end : {0, 1}) {
            if (room(range[end]) > 0) continue;
            double in = inside, out = range[end];
            for (int k = 0; k < enough; ++k) {
                const double middle = 0.5 * (in + out);
                (room(middle) > 0 ? in : out) = middle;
            }
            if (end == 0 ? out <= within.ends[0] : out >= within.ends[1]) continue;
            within.ends[end] = out;
            within.slants[end] = std::max(1.0, std::abs(out - inside) / most);
        }
    }
    return within;
}

// Next to a wall the cell is a needle: parts keep as clear of where it ends as of planes.
AxisParts::AxisParts(const Box& box, const BaseFrame& frame, const Within& within)
    : sides_(canonical_box(box, frame)) {
    const std::array<double, 2> of_box = AxisParts::range(box, frame),
                                range{std::max(of_box[0], within.ends[0]),
                                      std::min(of_box[1], within.ends[1])};
    ends_ = {{range[0], range[0] > of_box[0] ? within.slants[0] : 0},
             {range[1], range[1] < of_box[1] ? within.slants[1] : 0}};
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
