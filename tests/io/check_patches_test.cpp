/// Where rays meet trimmed patches, as the check finds it.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "../../io/check/patches.hpp"
#include "../test_support.hpp"

namespace vcell::check {
namespace {

Scene point_scene() {
    Scene scene;
    scene.base = Sphere{{0.5, -0.25, 1}, 0};
    scene.box = {{-10, -10, -10}, {10, 10, 10}};
    return scene;
}

/// Without loops: the rectangle lo, hi of the surface.
Patch rectangle(const RationalPatch& surface, const Vec2& lo, const Vec2& hi, double control_size) {
    return {0, 0, &surface, control_size, {}, lo, hi, lo, hi};
}

/// Control points at random, so that the surface folds and a line meets it several times.
RationalPatch random_surface(std::mt19937_64& rng) {
    std::normal_distribution<double> normal;
    RationalPatch s;
    s.degree_u = std::uniform_int_distribution(1, 5)(rng);
    s.degree_v = std::uniform_int_distribution(1, 5)(rng);
    s.domain_u = {-1, 2};
    s.domain_v = {-3e6, 4e6};  // an angle and a length, say
    for (int i = 0; i < (s.degree_u + 1) * (s.degree_v + 1); ++i)
        s.points.push_back({normal(rng), normal(rng), normal(rng), std::exp(2 * normal(rng))});
    return s;
}

}  // namespace

TEST_CASE("inside: is undecided as near to the loops as their errors, in units of u and of v") {
    constexpr double kWidth = 2e6, kError = 10;  // lengths; u is 0 to 1 across the width, v is a length
    RationalPatch surface;
    surface.degree_u = surface.degree_v = 1;
    surface.domain_u = {0, 1};
    surface.domain_v = {0, kWidth};
    surface.points = {{0, 0, 2, 1}, {0, kWidth, 2, 1}, {kWidth, 0, 2, 1}, {kWidth, kWidth, 2, 1}};
    const Vec2 lo(0.25, 0.25 * kWidth), hi(0.75, 0.75 * kWidth);
    Patch patch = rectangle(surface, lo, hi, kWidth);
    const std::array<Vec2, 4> corners{lo, Vec2(hi.x(), lo.y()), hi, Vec2(lo.x(), hi.y())};
    auto& loop = patch.loops.emplace_back();
    for (int i = 0; i < 4; ++i) {
        RationalCurve2 side;
        side.degree = 1;
        side.knots = {0, 0, 1, 1};
        for (const Vec2& q : {corners[i], corners[(i + 1) % 4]}) side.points.push_back({q.x(), q.y(), 1});
        loop.push_back({nullptr, kError, pieces(side)});
    }
    const Vec2 unit(1 / kWidth, 1);  // of length, in (u, v)
    for (int axis = 0; axis < 2; ++axis)
        for (const double along : {0.3, 0.5, 0.61})
            for (const double depth : {-1e5, -30.0, -5.0, 0.0, 5.0, 30.0, 1e5})
                for (const bool is_upper : {false, true}) {
                    CAPTURE(axis);
                    CAPTURE(along);
                    CAPTURE(depth);
                    CAPTURE(is_upper);
                    Vec2 uv(along, along * kWidth);
                    uv[axis] = is_upper ? hi[axis] - depth * unit[axis] : lo[axis] + depth * unit[axis];
                    const auto in = inside(patch, uv, 1e-9);
                    CHECK(in.has_value() == (std::abs(depth) > kError));
                    if (in) CHECK(*in == (depth > 0));
                }
}

TEST_CASE("part_of: is the same surface") {
    std::mt19937_64 rng(test_seed());
    for (int k = 0; k < 100; ++k) {
        const RationalPatch whole = random_surface(rng);
        const Vec2 lo(-0.5, -1e6), hi(1.75, 4e6);
        const RationalPatch part = part_of(whole, lo, hi);
        for (const double s : {0.0, 0.3, 1.0}) {
            const Vec2 uv = lo + Vec2(s, 1 - s).cwiseProduct(hi - lo);
            const SurfacePoint a = evaluate(whole, uv.x(), uv.y()), b = evaluate(part, uv.x(), uv.y());
            CHECK((a.p - b.p).norm() < 1e-12);
            CHECK((a.pu - b.pu).norm() < 1e-9 * a.pu.norm());
            CHECK((a.pv - b.pv).norm() < 1e-9 * a.pv.norm());
        }
    }
}

TEST_CASE("parameters: are all places where a ray meets a patch, and no others") {
    std::mt19937_64 rng(test_seed());
    const Scene scene = point_scene();
    const SceneGeometry geometry(scene);
    std::uniform_real_distribution<double> unit(0, 1);
    int undecided = 0, several = 0;
    constexpr int kRays = 5000;
    for (int k = 0; k < kRays; ++k) {
        const RationalPatch surface = random_surface(rng);
        const Vec2 lo(-0.75, -2e6), hi(1.5, 3e6), extent = hi - lo;
        const Patch patch = rectangle(surface, lo, hi, 10);
        const Vec2 uv = lo + Vec2(unit(rng), unit(rng)).cwiseProduct(extent);
        const Vec3 p = lift(patch, uv).p;
        const Ray ray = geometry.ray(p);
        const auto places = parameters(patch, ray, geometry);
        if (!places) {
            ++undecided;
            continue;
        }
        CAPTURE(k);
        CAPTURE(uv.transpose());
        // Near a fold the place is as sharp as a square root of rounding.
        CHECK(std::ranges::any_of(
            *places, [&](const Vec2& place) { return (place - uv).cwiseQuotient(extent).norm() < 1e-6; }));
        for (const Vec2& place : *places) {
            const Vec3 q = lift(patch, place).p - ray.at(ray.start);
            CHECK(ray.direction.dot(q) > 0);
            CHECK(ray.direction.cross(q).norm() < 1e-9 * (1 + q.norm()));
        }
        several += places->size() > 1;
    }
    CHECK(undecided <= kRays / 1000);
    CHECK(several > kRays / 10);
}

TEST_CASE("parameters: are none behind the ray's start, or far beside the patch") {
    const Scene scene = point_scene();
    const SceneGeometry geometry(scene);
    RationalPatch surface;  // bilinear, in the plane one above the base
    surface.degree_u = surface.degree_v = 1;
    surface.domain_u = surface.domain_v = {0, 1};
    surface.points = {{0, -1, 2, 1}, {0, 1, 2, 1}, {1, -1, 2, 1}, {1, 1, 2, 1}};
    const Patch patch = rectangle(surface, Vec2::Zero(), Vec2::Ones(), 10);
    const Vec3 centre(0.5, -0.25, 1);
    for (const auto& [x, y, z, count] : {std::array{0.0, 0.0, 1.0, 1.0},
                                         {0.25, 0.25, 1, 1},
                                         {0, 0, -1, 0},
                                         {-0.25, -0.25, -1, 0},
                                         {2, 0, 1, 0},
                                         {0, -3, 1, 0}}) {
        CAPTURE(x);
        CAPTURE(y);
        CAPTURE(z);
        const auto places = parameters(patch, geometry.ray(centre + Vec3(x, y, z)), geometry);
        REQUIRE(places);
        CHECK(places->size() == static_cast<std::size_t>(count));
    }
}

TEST_CASE("parameters: are undecided on a ray within the surface") {
    const Scene scene = point_scene();
    const SceneGeometry geometry(scene);
    RationalPatch surface;
    surface.degree_u = surface.degree_v = 1;
    surface.domain_u = surface.domain_v = {0, 1};
    surface.points = {{0.5, -1, 2, 1}, {0.5, 1, 2, 1}, {0.5, -1, 4, 1}, {0.5, 1, 4, 1}};
    const Patch patch = rectangle(surface, Vec2::Zero(), Vec2::Ones(), 10);
    CHECK_FALSE(parameters(patch, geometry.ray({0.5, -0.25, 3}), geometry));
}

}  // namespace vcell::check
