#include "nested_cylinders.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vcell {

namespace {

using Eigen::Vector3d;

// Bounds of a cylinder's numbers as they are found here: m - d (d.m) / d.d is off by less than 32 u of |m|, u
// = 2^-53, and points that differ by a multiple of d by as little; so are cosines. The rest is for sums, and
// for underflow.
constexpr double nesting_rounding = 0x1p-46, least = 0x1p-500;

struct Item {
    std::uint32_t index;
    Vector3d direction;    // of length 1 within a factor of 1 + nesting_rounding
    Vector3d foot;         // the axis's point nearest to the middle
    double radius, error;  // of the foot
    double key;            // of the foot, along the line
};

// May p contain q? Parallel axes have cosines of +-1, and feet that are no farther apart than their radii
// allow.
bool may_contain(const Item& p, const Item& q) {
    const double error = p.error + q.error + nesting_rounding * (p.radius + q.radius);
    return p.radius - q.radius + error >= 0 && p.direction.cross(q.direction).norm() <= nesting_rounding &&
           (p.foot - q.foot).norm() <= p.radius - q.radius + error;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> possible_containers(std::span<const CylinderForm> cylinders) {
    const std::size_t n = cylinders.size();
    std::vector<std::vector<std::uint32_t>> containers(n);
    Vector3d middle = Vector3d::Zero();
    for (const CylinderForm& f : cylinders) middle += Vector3d(f.px, f.py, f.pz) / static_cast<double>(n);
    std::vector<Item> items;
    items.reserve(n);
    bool are_numbers = true;
    for (std::uint32_t i = 0; i < n; ++i) {
        const CylinderForm& f = cylinders[i];
        const Vector3d axis(f.ax, f.ay, f.az), m = Vector3d(f.px, f.py, f.pz) - middle;
        const Vector3d d = (axis / axis.cwiseAbs().maxCoeff()).normalized();
        const double size = m.norm() + Vector3d(f.px, f.py, f.pz).norm() + middle.norm();
        items.push_back({i, d, m - d * d.dot(m), f.rho, nesting_rounding * size + least, 0});
        are_numbers = are_numbers && std::isfinite(items.back().foot.squaredNorm() + f.rho * f.rho);
    }
    if (!are_numbers) {  // out of the range of doubles: no pair is told apart
        for (std::uint32_t i = 0; i < n; ++i)
            for (std::uint32_t k = 0; k < n; ++k)
                if (k != i) containers[i].push_back(k);
        return containers;
    }
    Eigen::Index widest = 0;
    Eigen::AlignedBox3d box;
    for (const Item& item : items) box.extend(item.foot);
    if (n > 0) box.sizes().maxCoeff(&widest);
    double error = 0;
    for (Item& item : items) {
        item.key = item.foot[widest];
        error = std::max(error, item.error);
    }
    std::ranges::sort(items, {}, &Item::key);
    for (const Item& outer : items) {
        const double reach = outer.radius * (1 + nesting_rounding) + outer.error + error;
        auto inner =
            std::ranges::lower_bound(items, outer.key - reach * (1 + nesting_rounding), {}, &Item::key);
        for (; inner != items.end() && inner->key <= outer.key + reach * (1 + nesting_rounding); ++inner)
            if (inner->index != outer.index && may_contain(outer, *inner))
                containers[inner->index].push_back(outer.index);
    }
    for (std::vector<std::uint32_t>& c : containers) std::ranges::sort(c);
    return containers;
}

}  // namespace vcell
