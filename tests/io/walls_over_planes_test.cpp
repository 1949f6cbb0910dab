/// What the check knows by itself of planes in hollow tubes and cones: regions within walls, and tips.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "../../io/check/scene.hpp"
#include "../../io/check/tips.hpp"
#include "../test_support.hpp"
#include "floors_in_tubes.hpp"

namespace vcell {
namespace {

// The box leaves so much of a cone whose lowest line is level: half its angle has the tangent 3 / 4, and
// (x, y, 0) lies in it where the distance from the axis, of square (0.6 x - 0.4)^2 + y^2, is at most 3 / 4
// (0.8 x + 0.3).
double region_under_level_line() { return 2 * (2.0 / 3) / 0.75 * std::pow(0.75 * 2 - 0.109375, 1.5); }

struct WalledRegion {
    Plane base;
    std::vector<Object> walls;
    double area;
};

std::vector<WalledRegion> walled_regions() {
    const auto strip = [](double height) { return 2 * std::sqrt(1 - height * height); };
    const double slant = 4 - std::sqrt(0.5) * strip(0.5);
    std::vector<WalledRegion> walled_regions{
        {ground, {HollowCylinder{{1, 1, 0}, {1, 1, 0}, 1}}, 16 - std::pow(4 - std::sqrt(2), 2)},
        {ground, {HollowCylinder{{0, 0, 0.5}, {1, 1, 0}, 1}}, 16 - slant * slant},
        {ground,
         {HollowCylinder{{0, 0, 0.5}, {1, 0, 0}, 1}, HollowCylinder{{0, 0, -0.25}, {0, 1, 0}, 1}},
         strip(0.5) * strip(-0.25)},
        {ground,
         {HollowCylinder{{-0.5, 0, 0}, {0, 0, 1}, 1}, HollowSphere{{0.5, 0, 0.75}, 1.25}},
         2 * half_turn / 3 - std::sqrt(0.75)},
        {{{0, 0, 0.25}, {0.6, 0, 0.8}}, {HollowCylinder{{0.25, 0, 0}, {3, 0, 4}, 1}}, half_turn},
        {{{0, 0, 0.25}, {0.6, 0, 0.8}}, {HollowCylinder{{0.25, 0, 0}, {0, 0, 4}, 1}}, half_turn / 0.8},
        {ground, {HollowCone{{0.25, 0, -1}, {0, 0, 1}, 3, 5}}, 0.75 * 0.75 * half_turn},
        {ground, {HollowCone{{0.25, 0, 1.5}, {0, 0, -3}, 3, 5}}, 1.125 * 1.125 * half_turn},
        {ground, {HollowCone{{0, 0, -0.5}, {4, 0, 3}, 3, 5}}, region_under_level_line()},
    };
    for (const Vessel& v : lone_vessels()) walled_regions.push_back({ground, {v.tube}, v.base_area});
    return walled_regions;
}

}  // namespace

TEST_CASE("planes in tubes: the region's area is enclosed by polygons in and about it") {
    const std::vector<WalledRegion> all = walled_regions();
    for (std::size_t i = 0; i < all.size(); ++i) {
        CAPTURE(i);
        const Scene scene = floor_in(all[i].base, all[i].walls);
        const check::SceneGeometry geometry(scene);
        CHECK(geometry.has_curved_rim());
        const Interval area = geometry.shadow();
        CHECK(area.lower() <= all[i].area + 1e-12);
        CHECK(area.upper() >= all[i].area - 1e-12);
        CHECK(area.width() < 5e-4 * all[i].area);
    }
    // One that holds all of the region leaves all of it.
    const Scene scene = floor_in(ground, {HollowCylinder{{0.5, 0, 0}, {0.125, 0, 1}, 3.5}});
    const check::SceneGeometry geometry(scene);
    CHECK_FALSE(geometry.has_curved_rim());
    CHECK(geometry.shadow().contains(16));
}

// A wall that cuts the region twice leaves sides of a rounding's length, in any direction.
TEST_CASE("planes in tubes: rays are found among walls that are equal") {
    const HollowSphere wall{{-0.11878658886674708, -0.06632646583417963, -0.7792844884296132},
                            1.459010096413607};
    const Scene scene = floor_in({{0, 0, 0}, {-1, -1, -2}}, {wall, wall});
    const check::SceneGeometry geometry(scene);
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 20; ++i) CHECK(geometry.random_ray(rng, 0).has_value());
}

TEST_CASE("planes in tubes: a tip is where the axis is as high as the radius") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    for (int round = 0; round < 100; ++round) {
        const HollowCylinder tube{vector(), vector(), 0.5 + 0.25 * unit(rng)};
        const Scene scene = floor_in({vector(), vector()}, {tube});
        const check::Space<Interval> space(scene);
        const std::vector<check::Tip> tips = check::tips_of(space, tube);
        REQUIRE(tips.size() == 1);
        const Vec3 p = check::middle(tips[0].p), n = std::get<Plane>(scene.base).normal.normalized();
        const double size = p.norm() + 1;
        CHECK(check::radius(tips[0].p) < 1e-12 * size * size);
        CHECK(n.dot(p - std::get<Plane>(scene.base).point) ==
              doctest::Approx(tube.radius).epsilon(1e-12 * size * size));
        CHECK(tube.axis.normalized().cross(p - tube.point).norm() < 1e-12 * size * size);
        CHECK(tips[0].reach.contains(tube.radius));
    }
    // In cones it is where the axis is as high as the wall is far away, ahead of the apex, if there is one.
    int found = 0;
    for (int round = 0; round < 100; ++round) {
        const HollowCone cone{vector(), vector(), 1, 1.5 + 0.25 * unit(rng)};
        const Scene scene = floor_in({vector(), vector()}, {cone});
        const auto& base = std::get<Plane>(scene.base);
        const Vec3 n = base.normal.normalized(), axis = cone.axis.normalized();
        const double rise = n.dot(axis) - cone.sine(), height = n.dot(cone.apex - base.point);
        const std::vector<check::Tip> tips = check::tips_of(check::Space<Interval>(scene), cone);
        REQUIRE(tips.size() == (height * rise < 0 ? 1 : 0));
        if (tips.empty()) continue;
        ++found;
        const Vec3 p = check::middle(tips[0].p);
        CHECK((p - (cone.apex - height / rise * axis)).norm() < 1e-12 / (rise * rise));
        CHECK(n.dot(p - base.point) == doctest::Approx(tips[0].reach.mid()).epsilon(1e-12 / (rise * rise)));
    }
    CHECK(found > 20);
    const HollowCylinder level{{0, 0.5, 0.25}, {1, 2, 0}, 1};
    const Scene scene = floor_in(ground, {level});
    CHECK(check::tips_of(check::Space<Interval>(scene), level).empty());
}

}  // namespace vcell
