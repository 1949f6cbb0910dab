// Cells of balls and tubes that reach beyond the sides of their box: rays start in the centre or on the axis,
// so as long as these are in the box the cell is complete, and proved as any other.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
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

// Held by an object, such a mirror image has the side as near as that along a curve at most, and nowhere
// nearer.
TEST_CASE("certify: what holds the base as a side of the box mirrors it has all of the side's face") {
    for (const std::string name :
         {"line_mirrors_base", "tube_about_mirrored_ball", "wall_before_mirrored_ball",
          "plane_touches_mirrored_tube", "tube_about_mirrored_tube"}) {
        CAPTURE(name);
        const Scene scene = read_scene(test_data("hostile/" + name + ".json"));
        const Cell cell = voronoi_cell(scene);
        CHECK(cell.report.decisions.assumed == 0);
        const Certificate c = certify(cell);
        CHECK_MESSAGE(c.holds(), listing(c));
        // The line is held by the side instead.
        const bool is_of_side = name == "line_mirrors_base";
        const Site side = Site::box_side(1);
        CHECK(std::ranges::count(cell.faces, side, &CellFace::site) == (is_of_side ? 1 : 0));
        CHECK(std::ranges::count(cell.faces, Site::object(0), &CellFace::site) == (is_of_side ? 0 : 1));
        // Next to the tie nothing is, and cells change little.
        Scene next = scene;
        next.box.max.x() -= 0x1p-10;
        const Cell cut = voronoi_cell(next);
        CHECK(std::abs(cell.measures.volume - cut.measures.volume) < 0.3);
        CHECK(std::ranges::count(cut.faces, side, &CellFace::site) > 0);
    }
}

TEST_CASE("certify: a line that meets a base plane next to its region") {
    const Cell cell = voronoi_cell(read_scene(test_data("hostile/tip_next_to_region.json")));
    const Certificate c = certify(cell);
    CHECK_MESSAGE(c.holds(), listing(c));
    for (const CellEdge& edge : cell.edges) CHECK(edge.curve.points.size() < 1000);
}

}  // namespace vcell
