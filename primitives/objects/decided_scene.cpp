#include "decided_scene.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <variant>

namespace vcell {

namespace {

// Visits every length of a scene, coordinates included.
template <class S, class Visit>
void for_each_length(S& scene, Visit&& visit) {
    const auto point = [&](auto& p) {
        for (int i = 0; i < 3; ++i) visit(p[i]);
    };
    const auto object = [&](auto& o) {
        if (auto* sphere = std::get_if<Sphere>(&o)) {
            point(sphere->center);
            visit(sphere->radius);
        } else if (auto* plane = std::get_if<Plane>(&o)) {
            point(plane->point);
        } else if (auto* cylinder = std::get_if<Cylinder>(&o)) {
            point(cylinder->point);
            visit(cylinder->radius);
        } else if (auto* ball = std::get_if<HollowSphere>(&o)) {
            point(ball->center);
            visit(ball->radius);
        } else if (auto* tube = std::get_if<HollowCylinder>(&o)) {
            point(tube->point);
            visit(tube->radius);
        } else if (auto* cone = std::get_if<HollowCone>(&o)) {
            point(cone->apex);  // its radius and its slant count by their quotient
        }
    };
    object(scene.base);
    for (auto& o : scene.objects) object(o);
    point(scene.box.min);
    point(scene.box.max);
    if (scene.tolerance) visit(*scene.tolerance);
    if (scene.probe) visit(*scene.probe);
}

}  // namespace

Object cap_of(const Object& base, double probe) {
    if (const auto* ball = std::get_if<Sphere>(&base))
        return HollowSphere{ball->center, ball->radius + 2 * probe};
    if (const auto* tube = std::get_if<Cylinder>(&base))
        return HollowCylinder{tube->point, tube->axis, tube->radius + 2 * probe};
    const auto& plane = std::get<Plane>(base);
    return Plane{plane.point + 2 * probe * plane.normal.stableNormalized(), plane.normal};
}

Scene with_cap(Scene scene) {
    scene.objects.push_back(cap_of(scene.base, *scene.probe));
    if (!scene.names.empty()) scene.names.emplace_back();
    if (!scene.numbers.empty()) scene.numbers.push_back(Site::number_of_cap);
    if (!scene.images.empty()) scene.images.push_back({Site::number_of_cap, {0, 0, 0}});
    return scene;
}

DecidedScene decide(const Scene& scene) {
    constexpr int highest = 200;
    double largest = 0;
    for_each_length(scene, [&](double x) { largest = std::max(largest, std::abs(x)); });
    // The largest side has the scene's own digits; a rounded diagonal might cross a power of two with the
    // scale.
    const int exponent = std::max(std::ilogb((scene.box.max - scene.box.min).maxCoeff()),
                                  largest > 0 ? std::ilogb(largest) - highest : INT_MIN);
    DecidedScene decided{scene, std::ldexp(1.0, exponent), 0};
    const double factor = std::ldexp(1.0, -exponent);
    if (exponent != 0)
        for_each_length(decided.scene, [&](double& x) {
            const double scaled = factor * x;
            // Below the normal numbers digits are lost, and nowhere else.
            if (std::abs(scaled) < 0x1p-1000 && scaled * decided.unit != x)
                decided.moved = std::max(decided.moved, 0x1p-1074);
            x = scaled;
        });
    if (!scene.probe) return decided;
    // Messages know the cap by its number.
    std::vector<std::uint32_t>& numbers = decided.scene.numbers;
    if (numbers.empty()) {
        numbers.resize(scene.objects.size());
        std::iota(numbers.begin(), numbers.end(), 0u);
    }
    decided.scene = with_cap(std::move(decided.scene));
    return decided;
}

}  // namespace vcell
