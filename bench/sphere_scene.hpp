/// Scenes of the envelope's benches: disjoint spheres over a rectangle of the plane z = 0.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <istream>
#include <random>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "../envelope/diagram/minimization_diagram.hpp"
#include "../primitives/objects/objects.hpp"

namespace vcell::bench {

struct SphereScene {
    double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    std::vector<Sphere> spheres;

    ConvexRegion region() const { return ConvexRegion::rectangle(x0, y0, x1, y1); }
};

/// The clearances of the spheres over z = 0. The clearance t at (x, y) satisfies |(x, y, t) - c| = t + rho:
///
///     t = ((x - cx)^2 + (y - cy)^2 + (cz - rho) (cz + rho)) / (2 (cz + rho)),
///
/// exact for the doubles of the scene. Pre: every sphere lies above the plane, cz > rho; the scene outlives
/// the family.
inline FormFamily clearances(const SphereScene& scene) {
    FormFamily family;
    family.forms.reserve(scene.spheres.size());
    for (const Sphere& s : scene.spheres) {
        CircularForm form;
        form.k = 1;
        form.cx = s.center.x();
        form.cy = s.center.y();
        form.e = (s.center.z() - s.radius) * (s.center.z() + s.radius);
        form.w = 2 * (s.center.z() + s.radius);
        family.forms.push_back(form);
    }
    family.exact = [&spheres = scene.spheres](FormId f) {
        const Sphere& s = spheres[f.value];
        const Exact x(s.center.x()), y(s.center.y()), z(s.center.z()), r(s.radius);
        return ExactForm{1, Exact(-2) * x, Exact(-2) * y, x * x + y * y + (z - r) * (z + r),
                         Exact(2) * (z + r)};
    };
    return family;
}

/// n disjoint spheres at constant density: centres uniform in [0, sqrt n]^2 x [0.3, 1.5], radii in
/// [0.02, 0.25], clear of the plane, all coordinates multiples of 1e-6. The scene depends on n and seed
/// alone: the standard fixes the engine's numbers, and the rest is integer arithmetic.
inline SphereScene random_scene(std::uint32_t n, std::uint64_t seed = 1) {
    struct Ball {
        std::int64_t x, y, z, r;  // in units of 1e-6
    };
    constexpr std::int64_t unit = 1'000'000, largest_radius = 250'000;
    constexpr std::int64_t cell = 2 * largest_radius;  // balls that overlap lie in neighbouring cells
    const auto side = static_cast<std::int64_t>(std::sqrt(static_cast<double>(n)) * unit);
    const std::int64_t columns = side / cell + 3;  // an empty cell on either side

    std::mt19937_64 random(seed);
    // The bias of the remainder is below 2^-30 for the ranges here.
    const auto uniform = [&](std::int64_t low, std::int64_t high) {
        return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
    };
    std::unordered_map<std::int64_t, std::vector<Ball>> grid;
    grid.reserve(n);

    SphereScene scene;
    scene.x1 = scene.y1 = static_cast<double>(side) / unit;
    scene.spheres.reserve(n);
    while (scene.spheres.size() < n) {
        Ball b{};
        b.x = uniform(0, side);
        b.y = uniform(0, side);
        b.z = uniform(300'000, 1'500'000);
        b.r = uniform(20'000, largest_radius);
        const std::int64_t key = (b.y / cell + 1) * columns + b.x / cell + 1;
        const auto overlaps = [&](const Ball& o) {
            const std::int64_t dx = b.x - o.x, dy = b.y - o.y, dz = b.z - o.z, reach = b.r + o.r;
            return dx * dx + dy * dy + dz * dz <= reach * reach;
        };
        bool free = b.z > b.r;
        for (std::int64_t dy = -columns; dy <= columns; dy += columns)
            for (std::int64_t dx = -1; free && dx <= 1; ++dx)
                if (const auto found = grid.find(key + dy + dx); found != grid.end())
                    free = std::ranges::none_of(found->second, overlaps);
        if (!free) continue;
        grid[key].push_back(b);
        const auto length = [](std::int64_t millionths) { return static_cast<double>(millionths) / unit; };
        scene.spheres.push_back({{length(b.x), length(b.y), length(b.z)}, length(b.r)});
    }
    return scene;
}

/// side x side equal spheres on the unit lattice: every inner vertex is equally far from four of them.
inline SphereScene lattice_scene(std::uint32_t side) {
    SphereScene scene;
    scene.x1 = scene.y1 = side;
    scene.spheres.reserve(std::size_t{side} * side);
    for (std::uint32_t j = 0; j < side; ++j)
        for (std::uint32_t i = 0; i < side; ++i) scene.spheres.push_back({{i + 0.5, j + 0.5, 0.75}, 0.25});
    return scene;
}

/// n points within 1e-4 of a sphere of radius 2 that touches the plane at (4, 4), no lower than 0.2: all
/// their trisectors pass near that point, and no piece around it sees fewer than all of them.
inline SphereScene points_on_a_sphere(std::uint32_t n) {
    SphereScene scene;
    scene.x1 = scene.y1 = 8;
    std::mt19937_64 random(3);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    while (scene.spheres.size() < n) {
        const Vec3 d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
        const double length = d.norm();
        if (!(length > 0.1 && length <= 1)) continue;
        const Vec3 p = Vec3(4, 4, 2) + (2 + uniform(0, 1e-4)) / length * d;
        if (p.z() >= 0.2) scene.spheres.push_back({p, 0});
    }
    return scene;
}

/// Reads "xmin ymin xmax ymax", then "x y z r" for every sphere, separated by blanks or newlines.
inline SphereScene read_scene(std::istream& in) {
    SphereScene scene;
    if (!(in >> scene.x0 >> scene.y0 >> scene.x1 >> scene.y1) ||
        !(scene.x0 < scene.x1 && scene.y0 < scene.y1))
        throw std::runtime_error("expected a rectangle: xmin ymin xmax ymax");
    Sphere s;
    while (in >> s.center.x()) {
        if (!(in >> s.center.y() >> s.center.z() >> s.radius)) break;
        if (s.radius < 0 || s.center.z() <= s.radius)
            throw std::runtime_error("sphere " + std::to_string(scene.spheres.size()) +
                                     " does not lie above the plane");
        scene.spheres.push_back(s);
    }
    if (!in.eof() || scene.spheres.empty())
        throw std::runtime_error("expected x y z r for sphere " + std::to_string(scene.spheres.size()));
    return scene;
}

}  // namespace vcell::bench
