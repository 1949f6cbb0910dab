/// An oracle for balls in vessels that knows distances alone, and random scenes of them.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/point_query.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../test_support.hpp"

namespace vcell::vessel_oracle {

inline constexpr double pi = std::numbers::pi;

inline double away(const Object& object, const Vec3& p) {
    if (const auto* o = std::get_if<Plane>(&object))
        return std::abs(o->normal.dot(p - o->point)) / o->normal.norm();
    if (const auto* o = std::get_if<Sphere>(&object)) return (p - o->center).norm() - o->radius;
    if (const auto* o = std::get_if<HollowSphere>(&object)) return o->radius - (p - o->center).norm();
    const auto across = [&](const auto& tube) {
        return tube.axis.cross(p - tube.point).norm() / tube.axis.norm();
    };
    if (const auto* o = std::get_if<HollowCylinder>(&object)) return o->radius - across(*o);
    if (const auto* o = std::get_if<HollowCone>(&object)) {
        // The nearest of the planes that touch the wall: that along the generator beside p.
        const Vec3 w = o->axis.normalized(), m = p - o->apex, out = m - w.dot(m) * w;
        const double half = std::asin(o->radius / o->slant);
        return std::sin(half) * w.dot(m) - std::cos(half) * out.norm();
    }
    const auto& tube = std::get<Cylinder>(object);
    return across(tube) - tube.radius;
}

inline double inside_box(const Box& box, const Vec3& p) {
    return std::min((p - box.min).minCoeff(), (box.max - p).minCoeff());
}

// How far the cell of a base ball reaches in a direction from its centre.
inline double reach_along(const Scene& scene, const Vec3& u) {
    const auto& base = std::get<Sphere>(scene.base);
    double low = 0, high = scene.box.diagonal();
    for (int i = 0; i < 60; ++i) {
        const double t = 0.5 * (low + high);
        const Vec3 p = base.center + t * u;
        bool is_in = inside_box(scene.box, p) >= 0;
        for (std::size_t k = 0; k < scene.objects.size(); ++k)
            is_in = is_in && (!scene.competes(k) || away(scene.objects[k], p) >= t - base.radius);
        (is_in ? low : high) = t;
    }
    return low;
}

// The volume by a product rule of directions. Creases leave errors of the order of the square of its step.
inline double sampled_volume(const Scene& scene, int rows) {
    double sum = 0;
    for (int i = 0; i < rows; ++i) {
        const double z = -1 + 2 * (i + 0.5) / rows, r = std::sqrt(1 - z * z);
        for (int k = 0; k < 2 * rows; ++k) {
            const double phi = pi * (k + 0.5) / rows;
            const double t = reach_along(scene, Vec3(r * std::cos(phi), r * std::sin(phi), z));
            sum += t * t * t / 3;
        }
    }
    return sum * 2 * pi / rows / rows;
}

inline void check_volume(const Scene& scene, const Cell& cell) {
    CHECK(cell.measures.volume == doctest::Approx(sampled_volume(scene, 60)).epsilon(4e-3));
}

// Every vertex is as far from all its sites as from the base, every site of a face shows there.
inline void check_vertices(const Cell& cell) {
    const auto& base = std::get<Sphere>(cell.scene.base);
    for (const CellVertex& v : cell.vertices) {
        const double slop = 4 * v.error + 1e-13 * cell.scene.box.diagonal();
        CHECK(std::abs((v.point - base.center).norm() - base.radius - v.radius) <= slop);
        for (const Site& s : v.sites) {
            if (!s.is_object()) continue;
            CHECK(std::abs(away(cell.scene.objects[cell.scene.place(s.index)], v.point) - v.radius) <= slop);
        }
        for (std::size_t k = 0; k < cell.scene.objects.size(); ++k)
            if (cell.scene.competes(k)) CHECK(away(cell.scene.objects[k], v.point) >= v.radius - slop);
    }
}

// Owners of rays against distances.
inline void check_queries(const Scene& scene, std::mt19937_64& rng, int count) {
    PointQuery query(scene);
    const auto& base = std::get<Sphere>(scene.base);
    std::normal_distribution<double> normal;
    for (int i = 0; i < count; ++i) {
        const Vec3 u = Vec3(normal(rng), normal(rng), normal(rng)).normalized();
        const double t = reach_along(scene, u);
        const auto answer = query(base.center + 0.5 * t * u);
        REQUIRE(answer);
        CHECK(answer->inside);
        CHECK(answer->clearance == doctest::Approx(t - base.radius).epsilon(1e-9).scale(base.radius));
        if (answer->site && answer->site->is_object())
            CHECK(away(scene.objects[answer->site->index], base.center + t * u) ==
                  doctest::Approx(t - base.radius).epsilon(1e-9).scale(base.radius));
    }
}

inline std::set<std::uint32_t> owners(const Cell& cell) {
    return {cell.neighbors.begin(), cell.neighbors.end()};
}

// Balls that do not overlap, the first of which is the base, in a vessel, in a box around it.
inline Scene packed(std::mt19937_64& rng, const Object& vessel, std::size_t count, const Box& box) {
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Sphere> balls;
    for (int tries = 0; balls.size() < count && tries < 20'000; ++tries) {
        Sphere ball;
        for (int k = 0; k < 3; ++k) ball.center[k] = std::lerp(box.min[k], box.max[k], unit(rng));
        ball.radius = 0.1 + 0.1 * unit(rng);
        if (away(vessel, ball.center) < ball.radius || inside_box(box, ball.center) < ball.radius) continue;
        if (std::ranges::all_of(balls, [&](const Sphere& o) { return away(o, ball.center) >= ball.radius; }))
            balls.push_back(ball);
    }
    REQUIRE(balls.size() == count);
    Scene scene;
    scene.base = balls[0];
    scene.objects.assign(balls.begin() + 1, balls.end());
    scene.objects.push_back(vessel);
    scene.box = box;
    return scene;
}

// Is the volume of all balls' cells the share of random points that are nearer to a ball than to all walls?
inline void check_share_of_balls(const std::vector<Object>& objects, const Box& box, double volume,
                                 double error, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> unit(0, 1);
    const int count = 100'000;
    int hits = 0;
    for (int i = 0; i < count; ++i) {
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = std::lerp(box.min[k], box.max[k], unit(rng));
        double ball = 1e9, other = 1e9;
        for (const Object& o : objects) {
            double& least = std::holds_alternative<Sphere>(o) ? ball : other;
            least = std::min(least, away(o, p));
        }
        hits += ball < other;
    }
    const double all = (box.max - box.min).prod(), share = static_cast<double>(hits) / count;
    CHECK(std::abs(volume - all * share) < 5 * all * std::sqrt(share * (1 - share) / count) + error);
}

/// What an error's kind adds to its path in complaint().
inline std::string kind(InputError::Kind k) { return " " + std::to_string(static_cast<int>(k)); }
/// The path and kind of the InputError that the scene gets; "none" where it has a cell.
inline std::string complaint(const Scene& scene, const CellOptions& options = {}) {
    try {
        voronoi_cell(scene, options);
    } catch (const InputError& e) {
        return e.path + kind(e.kind);
    }
    return "none";
}

}  // namespace vcell::vessel_oracle
