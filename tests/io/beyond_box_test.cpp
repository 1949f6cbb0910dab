// Cells of balls and tubes that reach beyond the sides of their box: rays start in the centre or on the axis,
// so as long as these are in the box the cell is complete, and proved as any other.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>

#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../test_support.hpp"
#include "listing.hpp"

namespace vcell {
namespace {

/// The base among balls at random, some beyond the box and some that overlap the base, and a tube.
Scene scene_around(const Object& base, const Object& tube, double radius, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> place(-1, 11), radii(0, 1);
    Scene scene;
    scene.base = base;
    scene.box = {Vec3::Zero(), Vec3::Constant(10)};
    scene.objects.push_back(tube);
    while (scene.objects.size() < 12) {
        const double x = place(rng), y = place(rng), z = place(rng), r = radii(rng);
        const Vec3 p(x, y, z);
        const auto* ball = std::get_if<Sphere>(&base);
        const auto* line = std::get_if<Cylinder>(&base);
        const double away = ball != nullptr ? (p - ball->center).norm()
                                            : line->axis.normalized().cross(p - line->point).norm();
        if (away > std::abs(r - radius) + 0.25) scene.objects.emplace_back(Sphere{p, r});
    }
    return scene;
}

/// Is the cell proved, and is it all that is nearest to the base? Nothing of it may be refuted.
bool is_proved(const Scene& scene, bool is_complete) {
    const Cell cell = voronoi_cell(scene);
    const Certificate c = certify(cell);
    CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
    const CompleteMeasures complete = complete_measures(scene);
    const double missing = complete.volume - cell.measures.volume,
                 error = cell.measures.volume_error + complete.volume_error;
    CHECK(missing >= -error);
    if (is_complete) CHECK(missing <= error);
    return c.holds();
}

}  // namespace

TEST_CASE("certify: proves cells of balls that reach beyond the sides of their box") {
    std::mt19937_64 rng(test_seed());
    int proved = 0;
    for (const Sphere& base :
         {Sphere{{0.4, 5, 5}, 1}, Sphere{{9.8, 0.1, 5}, 1.5}, Sphere{{0.1, 9.95, 0.4}, 2.5},
          Sphere{{1, 1, 9}, 4}, Sphere{{5, 5, 1e-9}, 2}, Sphere{{2, 5, 5}, 2}}) {
        CAPTURE(base.center.transpose());
        const Cylinder tube{{5, base.center.y() < 5 ? 8.0 : 2.0, 0}, {1, 0.5, 1}, 0.25};
        proved += is_proved(scene_around(base, tube, base.radius, rng), true);
    }
    CHECK(proved >= 5);
}

TEST_CASE("certify: proves cells of tubes along a side of their box that reach beyond it") {
    std::mt19937_64 rng(test_seed());
    int proved = 0;
    for (const Cylinder& base :
         {Cylinder{{0.4, 5, 5}, {0, 0, 1}, 1}, Cylinder{{5, 9.9, 0.1}, {1, 0, 0}, 2},
          Cylinder{{1e-5, 5, 1e-6}, {0, 1, 0}, 1}, Cylinder{{2, 5, 5}, {0, 1, 0}, 2},
          Cylinder{{0.5, 5, 5}, {0, 1, 1}, 1}, Cylinder{{5, 9.75, 5}, {3, 0, 1}, 0.5}}) {
        CAPTURE(base.point.transpose());
        const Cylinder tube{{5, 5, base.point.z() < 5 ? 8.0 : 2.0}, base.axis, 0.25};
        // Those that run into a side obliquely end before they reach beyond that.
        const bool is_upright = (base.axis.array() != 0).count() == 1;
        proved += is_proved(scene_around(base, tube, base.radius, rng), is_upright);
    }
    CHECK(proved >= 5);
}

}  // namespace vcell
