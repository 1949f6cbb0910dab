#include "vessel_starts.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "space.hpp"
#include "triads.hpp"

namespace vcell::check {

namespace {

// Towards what may keep a direction from a vessel's face: other objects as seen from a ball's centre.
Vec3 direction_to(const Object& object, const Vec3& from) {
    if (const auto* ball = std::get_if<Sphere>(&object)) return ball->center - from;
    if (const auto* plane = std::get_if<Plane>(&object))
        return plane->normal.dot(plane->point - from) < 0 ? Vec3(-plane->normal) : plane->normal;
    if (const auto* tube = std::get_if<Cylinder>(&object)) {
        const Vec3 axis = tube->axis.stableNormalized(), way = tube->point - from;
        return way - axis.dot(way) * axis;
    }
    return Vec3::Zero();
}

}  // namespace

std::optional<Triad<MidRad>> start_in_vessel(const Scene& scene, const Frame& frame, const Site& site,
                                             std::span<const Triad<double>> points,
                                             const std::function<MidRad(const Vec3& u)>& distance) {
    const Sphere& base = std::get<Sphere>(scene.base);
    Vec3 mean = Vec3::Zero();
    for (const auto& p : points) mean += Vec3(p[0], p[1], p[2]).normalized();
    // Any start will do: directions in which two objects are as near to each other, as parts of the distance,
    // are in doubt and left out.
    constexpr double doubt = 0x1p-20;
    const auto is_of_others = [&](const Vec3& u) {
        const MidRad t = distance(u);
        if (!(t.radius() < HUGE_VAL)) return false;
        const Vec3 p = base.center + frame.unit() * t.mid() * u;
        const double clearance = frame.unit() * t.mid() - base.radius,
                     margin = doubt * (std::abs(clearance) + base.radius);
        if (((p - scene.box.min).array() < -margin).any() || ((scene.box.max - p).array() < -margin).any())
            return true;
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            if (!scene.competes(i) || i == site.index) continue;
            const Interval d = Surface<Interval>(scene.objects[i]).distance(to_vector<Interval>(p));
            const bool is_plane = std::holds_alternative<Plane>(scene.objects[i]);
            if ((is_plane ? magnitude(d) : d).upper() < clearance - margin) return true;
        }
        return false;
    };
    struct Opposite {
        Vec3 direction;
        double nearness;  // greatest cosine of the angle to a point of an edge
    };
    std::vector<Opposite> opposites;
    const auto add = [&](const Vec3& way) {
        if (!(way.norm() > 0)) return;
        Opposite o{way.stableNormalized(), -1};
        for (const auto& p : points)
            o.nearness = std::max(o.nearness, o.direction.dot(Vec3(p[0], p[1], p[2]).normalized()));
        opposites.push_back(o);
    };
    add(-mean);
    for (int k = 0; k < 3; ++k)
        for (const double sign : {-1.0, 1.0}) add(sign * Vec3::Unit(k));
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.competes(i)) add(direction_to(scene.objects[i], base.center));
    // What a face that is more than half of all around leaves out may be narrow: it lies between its edges.
    constexpr std::size_t most_points = 16;
    const std::size_t step = points.size() / most_points + 1;
    for (std::size_t i = 0; i < points.size(); i += step)
        for (std::size_t j = 0; j < i; j += step) {
            const auto &p = points[i], &q = points[j];
            add(Vec3(p[0], p[1], p[2]).normalized() + Vec3(q[0], q[1], q[2]).normalized());
        }
    std::ranges::stable_sort(opposites, {}, &Opposite::nearness);
    for (const Opposite& o : opposites)
        if (is_of_others(o.direction)) {
            const Vec3 s = -o.direction;
            return normalized(Triad<MidRad>{s.x(), s.y(), s.z()});
        }
    return std::nullopt;
}

}  // namespace vcell::check
