#include "axis_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "../primitives/bases/cylinder_base.hpp"
#include "object_distance.hpp"

namespace vcell {

namespace {

// The least and the greatest height of the box's corners.
std::array<double, 2> heights_of(const Box& box, const BaseFrame& frame) {
    std::array<double, 2> range{infinity, -infinity};
    for (unsigned corner = 0; corner < 8; ++corner) {
        const auto coordinate = [&](unsigned axis) {
            return ((corner & 1u << axis) != 0 ? box.max : box.min)[axis];
        };
        const double y = frame.to_canonical({coordinate(0), coordinate(1), coordinate(2)}).y();
        range = {std::min(range[0], y), std::max(range[1], y)};
    }
    return range;
}

}  // namespace

std::array<double, 2> AxisParts::range(const Box& box, const BaseFrame& frame) {
    const std::array<double, 2> range = heights_of(box, frame);
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

// Objects that the axis all but touches from within are none: too little would be known beside them.
std::vector<AxisParts::Holder> AxisParts::holders(const Scene& scene, const Cylinder& base,
                                                  const BaseFrame& frame) {
    std::vector<Holder> found;
    const auto add = [&](const Holder& h) {
        if (h.deep > h.apart &&
            h.rest(std::sqrt((h.deep - h.apart) * (h.deep + h.apart))) > Holder::least_rest)
            found.push_back(h);
    };
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        if (!scene.competes(i)) continue;
        if (const auto* ball = std::get_if<Sphere>(&scene.objects[i])) {
            const Vec3 c = frame.to_canonical(ball->center);
            add({c.y(), std::hypot(c.x(), c.z()), 1, ball->radius - base.radius});
        } else if (const auto* tube = std::get_if<Cylinder>(&scene.objects[i])) {
            // The nearest points of the axes: of the other one h beyond its point. NaN of parallel ones.
            const Vec3 p = frame.to_canonical(tube->point),
                       a = frame.rotation * tube->axis.stableNormalized();
            const double lean = std::hypot(a.x(), a.z()),
                         h = -(p.x() * a.x() + p.z() * a.z()) / (lean * lean);
            add({p.y() + h * a.y(), std::abs(p.x() * a.z() - p.z() * a.x()) / lean, lean,
                 tube->radius - base.radius});
        }
    }
    return found;
}

// With m the way from the holder's centre or axis, and u across the base's axis, a point of the cell is t
// away from that where |m + t u|, or what of it is across the holder's axis, is t + deep or more:
//
//     t <= C / (2 (deep - m.u)),   C = |m|^2 - deep^2.
AxisParts::LeftOut AxisParts::Holder::needle(double beyond) const {
    constexpr double room = 2;  // for proofs in intervals
    const double off = lean * (reach(0)[1] + beyond - foot),
                 C = std::max(0.0, off * off - (deep - apart) * (deep + apart)), width = C / (2 * deep),
                 rest = this->rest(off);
    if (!(rest > 0.5 * least_rest)) return {beyond};  // as of any slab
    const double most = width / rest * (1 + std::sqrt(1 - rest));
    return {0, room * beyond * std::numbers::pi * width * width / (rest * std::sqrt(rest)),
            2 * std::numbers::pi * most * (beyond + most)};
}

AxisParts::LeftOut AxisParts::left_out_before(const std::array<double, 2>& part,
                                              const std::array<double, 2>& stretch, AxialEnd end) const {
    const auto i = static_cast<std::size_t>(end);
    for (const Holder& holder : held_) {
        if (holder.reach(0)[1 - i] == part[i]) return holder.needle(std::abs(stretch[i] - part[i]));
    }
    const double held = within_box(part, 0)[i];
    LeftOut slab{std::max(0.0, end == AxialEnd::Low ? stretch[i] - held : held - stretch[i])};
    // Both planes run through it as far as the box reaches. The one that lies more across the axis has the
    // more of it.
    for (const End& crossing : crossings_)
        if (crossing.y == part[i]) slab.area += 2 * crossing.slant * slab.width * diagonal_;
    return slab;
}

void AxisParts::leave_out(const std::array<double, 2>& held) {
    std::vector<std::array<double, 2>> left;
    for (const auto& [from, to] : parts_) {
        if (from < std::min(to, held[0])) left.push_back({from, std::min(to, held[0])});
        if (std::max(from, held[1]) < to) left.push_back({std::max(from, held[1]), to});
    }
    parts_ = std::move(left);
}

// The planes are half of the axes' angle away from either.
void AxisParts::end_at_crossings(const Scene& scene, const Cylinder& base, const BaseFrame& frame) {
    const auto [low, high] = std::array{ends_[0].y, ends_[1].y};
    for (const auto& [place, y] : crossing_tubes(scene, base)) {
        if (y < low || y > high) continue;
        const Vec3 a = frame.rotation * std::get<Cylinder>(scene.objects[place]).axis.stableNormalized();
        crossings_.push_back({y, std::sqrt(2 * (1 + std::abs(a.y()))) / std::hypot(a.x(), a.z())});
    }
    ends_.insert(ends_.end(), crossings_.begin(), crossings_.end());
}

// Next to a wall the cell is a needle: parts keep as clear of where it ends as of planes.
AxisParts::AxisParts(const Scene& scene, const Cylinder& base, const Box& box, const BaseFrame& frame)
    : diagonal_(scene.box.diagonal()),
      sides_(canonical_box(box, frame)),
      box_ends_(std::ranges::any_of(sides_, is_across) ? std::array{-infinity, infinity}
                                                       : heights_of(box, frame)),
      held_(holders(scene, base, frame)) {
    const std::array<double, 2> of_box = AxisParts::range(box, frame);
    const Within within = within_vessels(scene, base, frame, of_box);
    const std::array<double, 2> range{std::max(of_box[0], within.ends[0]),
                                      std::min(of_box[1], within.ends[1])};
    ends_ = {{range[0], range[0] > of_box[0] ? within.slants[0] : 0},
             {range[1], range[1] < of_box[1] ? within.slants[1] : 0}};
    end_at_crossings(scene, base, frame);
    for (const BoxSide& side : sides_)
        if (side.m.y() != 0 && !is_across(side))
            ends_.push_back({side.k / side.m.y(), 1 / std::abs(side.m.y())});
    std::ranges::sort(ends_, {}, &End::y);
    for (std::size_t i = 0; i + 1 < ends_.size(); ++i)
        if (ends_[i].y >= range[0] && ends_[i + 1].y <= range[1] && ends_[i].y < ends_[i + 1].y)
            parts_.push_back({ends_[i].y, ends_[i + 1].y});
    std::erase_if(held_, [&](const Holder& holder) {
        return holder.reach(0)[1] <= range[0] || holder.reach(0)[0] >= range[1];
    });
    for (const Holder& holder : held_) leave_out(holder.reach(0));
}

std::array<double, 2> AxisParts::clear_of_planes(const std::array<double, 2>& part, double least) const {
    const double room = least * diagonal_, middle = 0.5 * part[0] + 0.5 * part[1];
    std::array<double, 2> stretch = part;
    for (const End& end : ends_) {
        if (end.y < middle)
            stretch[0] = std::max(stretch[0], end.y + room * end.slant);
        else
            stretch[1] = std::min(stretch[1], end.y - room * end.slant);
    }
    const double beside_needle =
        AxisParts::beside_needle * std::sqrt(least / least_rooms.front()) * diagonal_;
    for (const Holder& holder : held_) {
        const std::array<double, 2> reach = holder.reach(beside_needle);
        if (holder.foot < middle)
            stretch[0] = std::max(stretch[0], reach[1]);
        else
            stretch[1] = std::min(stretch[1], reach[0]);
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
