#include "feet.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>

#include "../../core/errors.hpp"

namespace vcell {

namespace {

template <class Object>
concept Vessel = std::same_as<Object, HollowSphere> || std::same_as<Object, HollowCylinder> ||
    std::same_as<Object, HollowCone>;
[[noreturn]] void fail_vessel() {
    throw InputError(InputError::Kind::Unsupported, InputError::no_object, "base",
                     "is a vessel, which is no base: objects lie in it");
}

Vec3 foot_of(const Vessel auto&, const Vec3&) { fail_vessel(); }
Vec3 foot_of(const Sphere& base, const Vec3&) { return base.center; }
Vec3 foot_of(const Cylinder& base, const Vec3& p) {
    const Vec3 d = base.axis.stableNormalized();
    return base.point + d.dot(p - base.point) * d;
}
Vec3 foot_of(const Plane& base, const Vec3& p) {
    const Vec3 n = base.normal.stableNormalized();
    return p - n.dot(p - base.point) * n;
}
Vec3 beside(const Vessel auto&) { fail_vessel(); }
Vec3 beside(const Plane& base) { return base.point + base.normal; }
Vec3 beside(const Sphere& base) { return base.center; }
Vec3 beside(const Cylinder& base) { return base.point; }

// A box that grows until it holds what it is asked to.
class Surroundings {
public:
    explicit Surroundings(const Box& region)
        : region_(region), margin_(0x1p-4 * region.diagonal()), box_(region) {}

    // [low, high] along an axis well inside, or within the region's own sides.
    void hold(int axis, double low, double high) {
        if (!(region_.min[axis] < low)) box_.min[axis] = std::min(box_.min[axis], low - margin(low));
        if (!(high < region_.max[axis])) box_.max[axis] = std::max(box_.max[axis], high + margin(high));
    }
    const Box& box() const { return box_; }

private:
    double margin(double at) const { return margin_ + 0x1p-40 * std::abs(at); }

    Box region_;
    double margin_;
    Box box_;
};

void hold_feet(Surroundings&, const Vessel auto&, const Box&) { fail_vessel(); }
void hold_feet(Surroundings& around, const Sphere& base, const Box&) {
    for (int k = 0; k < 3; ++k) around.hold(k, base.center[k], base.center[k]);
}
// visit(foot, doubt) for each corner of a region: the box that comes of them is wider than feet are off by
// rounding.
template <class Base, class Visit>
void for_feet_of_corners(const Base& base, const Box& region, Visit visit) {
    constexpr double rounding = 0x1p-40;  // far more than that, of the lengths that it comes from
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner((i & 1 ? region.max : region.min).x(), (i & 2 ? region.max : region.min).y(),
                          (i & 4 ? region.max : region.min).z());
        visit(foot_of(base, corner), rounding * ((corner - base.point).norm() + corner.norm()));
    }
}
// A plane across an axis may lie on a side of the region, if that is on the plane's side.
void hold_feet(Surroundings& around, const Plane& base, const Box& region) {
    const bool is_straight = (base.normal.array() != 0).count() == 1;
    for_feet_of_corners(base, region, [&](const Vec3& foot, double doubt) {
        for (int k = 0; k < 3; ++k) {
            if (base.normal[k] == 0) continue;
            if (!is_straight) {
                around.hold(k, foot[k] - doubt, foot[k] + doubt);
            } else if (const double at = base.point[k];
                       at != (base.normal[k] > 0 ? region.min : region.max)[k]) {
                around.hold(k, at, at);
            }
        }
    });
}
// A tube runs into sides obliquely where its circles reach them: with its feet the region needs these.
void hold_feet(Surroundings& around, const Cylinder& base, const Box& region) {
    const bool is_straight = (base.axis.array() != 0).count() == 1;
    const Vec3 d = base.axis.stableNormalized();
    for_feet_of_corners(base, region, [&](const Vec3& foot, double doubt) {
        for (int k = 0; k < 3; ++k) {
            if (is_straight && base.axis[k] != 0) continue;
            const double reach = is_straight ? 0 : base.radius * std::sqrt(1 - std::min(1.0, d[k] * d[k]));
            around.hold(k, foot[k] - reach - doubt, foot[k] + reach + doubt);
        }
    });
}

// Is all of it certainly in front of a plane?
bool is_in_front(const Plane& plane, const Object& other) {
    constexpr double rounding = 0x1p-45;
    const Vec3 n = plane.normal.stableNormalized();
    const auto is_clear = [&](const Vec3& p, double radius) {
        return n.dot(p - plane.point) - radius > rounding * (p.norm() + plane.point.norm() + radius);
    };
    if (const auto* sphere = std::get_if<Sphere>(&other)) return is_clear(sphere->center, sphere->radius);
    const auto* tube = std::get_if<Cylinder>(&other);
    return tube != nullptr && n.cwiseProduct(tube->axis).isZero(0) && is_clear(tube->point, tube->radius);
}

}  // namespace

Object turned_over(const Object& object) {
    const auto* plane = std::get_if<Plane>(&object);
    return plane == nullptr ? object : Plane{plane->point, -plane->normal};
}

Object seen_from(const Object& object, const Vec3& p) {
    const auto* plane = std::get_if<Plane>(&object);
    return plane == nullptr || plane->normal.dot(p - plane->point) > 0 ? object : turned_over(object);
}

std::vector<Object> sides_to_look_from(const Object& base, std::span<const Object> others) {
    std::vector<Object> sides{base};
    const auto* plane = std::get_if<Plane>(&base);
    if (plane == nullptr) return sides;
    const Plane behind{plane->point, -plane->normal};
    const auto none_in_front = [&](const Plane& of) {
        return std::ranges::none_of(others, [&](const Object& o) { return is_in_front(of, o); });
    };
    if (none_in_front(*plane)) sides.emplace_back(behind);
    if (sides.size() == 2 && !none_in_front(behind)) sides.erase(sides.begin());
    return sides;
}

Vec3 foot_of(const Object& base, const Vec3& p) {
    return std::visit([&](const auto& o) { return foot_of(o, p); }, base);
}

Vec3 beside(const Object& base) {
    return std::visit([](const auto& o) { return beside(o); }, base);
}

Box box_with_feet(const Object& base, const Box& region) {
    Surroundings around(region);
    std::visit([&](const auto& o) { hold_feet(around, o, region); }, base);
    return around.box();
}

}  // namespace vcell
