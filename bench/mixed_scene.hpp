/// Scenes of bench_mixed: balls and rods over a square of the plane z = 0, and single pairs of objects.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "../primitives/objects/scene.hpp"

namespace vcell::bench {

/// Numbers that depend on the seed alone: the standard fixes the engine's, and all are multiples of 1e-6.
class RandomLengths {
public:
    explicit RandomLengths(std::uint64_t seed) : random_(seed) {}

    double uniform(double low, double high) {
        const auto first = static_cast<std::int64_t>(std::ceil(low * unit)),
                   last = static_cast<std::int64_t>(std::floor(high * unit));
        // The bias of the remainder is below 2^-30 for the ranges here.
        const auto step = static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(last - first + 1));
        return static_cast<double>(first + step) / unit;
    }

private:
    static constexpr double unit = 1e6;
    std::mt19937_64 random_;
};

/// The signed distance from the surface, negative inside.
inline double distance(const Sphere& s, const Vec3& p) { return (p - s.center).norm() - s.radius; }
inline double distance(const Cylinder& c, const Vec3& p) {
    return (p - c.point).cross(c.axis.normalized()).norm() - c.radius;
}

/// n objects at constant density: sqrt(2 n) rods, as many as a strip of constant width holds, and balls. Rods
/// lie in four layers, along and across in turn, none quite parallel to another or to the base. Objects are
/// disjoint over the box and clear of the base. Pre: n >= 8.
inline Scene mixed_pile(std::uint32_t n, std::uint64_t seed = 1) {
    constexpr double gap = 0.01, low = 0.4, high = 2.8;
    constexpr int layers = 4;
    const auto rods = static_cast<std::uint32_t>(std::lround(std::sqrt(2.0 * n)));
    const double side = 0.6 * rods;
    RandomLengths random(seed);

    // Each rod has a track of its own in its layer, and stays on it over the box.
    const double track = side / std::ceil(rods / static_cast<double>(layers));
    std::vector<Cylinder> cylinders;
    for (std::uint32_t k = 0; k < rods; ++k) {
        const int layer = static_cast<int>(k % layers);
        const double place = (k / layers + random.uniform(0.3, 0.7)) * track;
        const double turn = random.uniform(-0.2, 0.2) * track / side, lean = random.uniform(-0.2, 0.2) / side;
        const double height = low + (high - low) * (layer + random.uniform(0.4, 0.6)) / layers;
        const bool along = layer % 2 == 0;
        cylinders.push_back({along ? Vec3(side / 2, place, height) : Vec3(place, side / 2, height),
                             along ? Vec3(1, turn, lean) : Vec3(turn, 1, lean), random.uniform(0.03, 0.12)});
    }
    std::vector<Sphere> spheres;
    while (spheres.size() + rods < n) {
        Sphere s;
        s.radius = random.uniform(0.1, 0.5);
        s.center = {random.uniform(0, side), random.uniform(0, side), random.uniform(s.radius + gap, high)};
        const auto clear = [&](const auto& o) { return distance(o, s.center) > s.radius + gap; };
        if (std::ranges::all_of(spheres, clear) && std::ranges::all_of(cylinders, clear))
            spheres.push_back(s);
    }

    Scene scene;
    scene.base = Plane{};
    scene.objects.assign(spheres.begin(), spheres.end());
    scene.objects.insert(scene.objects.end(), cylinders.begin(), cylinders.end());
    scene.box = {{0, 0, 0}, {side, side, 4}};
    return scene;
}

/// A cylinder and a sphere or second cylinder over the square [-1, 1]^2, clear of it. The box is so high that
/// its top is nowhere nearest.
inline Scene random_pair(RandomLengths& random, bool with_sphere) {
    const auto place = [&] {
        return Vec3(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), random.uniform(0.3, 1.4));
    };
    // No point of the square is farther than 0.03 from the grid's.
    const auto clear = [](const Cylinder& c) {
        constexpr int steps = 48;
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps; ++j)
                if (distance(c, {2.0 * i / steps - 1, 2.0 * j / steps - 1, 0}) < 0.05) return false;
        return true;
    };
    const auto cylinder = [&] {
        while (true) {
            const Cylinder c{place(),
                             {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.5, 0.5)},
                             random.uniform(0.05, 0.3)};
            if (c.axis.head<2>().norm() > 0.1 && clear(c)) return c;
        }
    };
    Scene scene;
    scene.base = Plane{};
    scene.objects.push_back(cylinder());
    if (with_sphere) {
        Sphere s{place(), 0};
        s.radius = random.uniform(0.05, 0.25);
        scene.objects.push_back(s);
    } else {
        scene.objects.push_back(cylinder());
    }
    scene.box = {{-1, -1, 0}, {1, 1, 16}};
    return scene;
}

}  // namespace vcell::bench
