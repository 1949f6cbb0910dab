/// Enclosures of vertices from doubles alone, against those in 320 bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/krawczyk.hpp"
#include "../test_support.hpp"
#include "random_scenes.hpp"

namespace vcell::check {

TEST_CASE("enclose_nearby: holds the point that three sites fix, from wherever it starts") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    for (const bool over_plane : {false, true}) {
        CAPTURE(over_plane);
        int found = 0, narrow = 0;
        for (int k = 0; k < 12; ++k) {
            const Scene scene = over_plane ? scene_over_plane(rng, 10, 2) : scene_about_ball(rng, 10, 2);
            const Cell cell = voronoi_cell(scene);
            const Space<Interval> space(cell.scene);
            const Space<Wide> wide(cell.scene);
            for (const CellVertex& v : cell.vertices) {
                if (v.sites.size() != 3) continue;
                // Sides of the box may be met over a plane by the boundary or the region.
                if (over_plane && !std::ranges::all_of(v.sites, [](const Site& s) { return s.is_object(); }))
                    continue;
                const std::array<Condition, 3> three{Condition{v.sites[0]}, Condition{v.sites[1]},
                                                     Condition{v.sites[2]}};
                const auto truth = enclose(wide, three, v.point, 1e-3, 16);
                if (!truth) continue;
                for (const double off : {0.0, 1e-14, 1e-11, 1e-8, 1e-5, 1e-2}) {
                    const Vec3 start = v.point + off * Vec3(normal(rng), normal(rng), normal(rng));
                    const auto box = enclose_nearby(cell.scene, space, three, start);
                    if (!box) continue;
                    ++found;
                    narrow += box->distance(v.point).upper() < 1e-13;
                    for (std::size_t i = 0; i < 3; ++i) {
                        const Interval x = (box->center[i] + box->offset[i]);
                        const Interval true_x = truth->box()[i].enclosure();
                        CHECK(x.lower() <= true_x.upper());
                        CHECK(x.upper() >= true_x.lower());
                    }
                }
            }
        }
        CHECK(found > 200);
        CHECK(narrow > 50);
    }
}

TEST_CASE("independent: of sites that tie it takes those that tell best where the point is") {
    // Two tubes and two sides of the box meet: the sides are known exactly, the tubes to several roundings.
    Scene scene;
    scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
    scene.objects = {Cylinder{{0, 0, 1}, {1, 0, 0}, 0.25}, Cylinder{{0, 0, 1}, {0, 1, 0}, 0.25}};
    scene.box = {{-1, -1, 0}, {1, 1, 2}};
    const Space<Interval> space(scene);
    const Vec3 p(-1, 1, 0.775);
    const std::vector<Condition> all{
        {Site::object(0)}, {Site::object(1)}, {Site::box_side(0)}, {Site::box_side(3)}};
    const std::vector<Condition> chosen = independent(space, all, p);
    REQUIRE(chosen.size() == 3);
    CHECK(std::ranges::count_if(chosen, [](const Condition& c) { return !c.site.is_object(); }) == 2);
    const auto box = enclose(space, {chosen[0], chosen[1], chosen[2]}, p, 0.1, 4);
    REQUIRE(box);
    CHECK(box->distance(p).upper() < 4e-15);
}

TEST_CASE("enclose_nearby: finds no point where there is none") {
    // Three balls in a line have no point in common with the plane but where they are met, far away.
    Scene scene;
    scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    for (const double x : {-1.0, 0.0, 1.0}) scene.objects.push_back(Sphere{{x, 0, 1}, 0.25});
    const Space<Interval> space(scene);
    const std::array<Condition, 3> three{Condition{Site::object(0)}, Condition{Site::object(1)},
                                         Condition{Site::object(2)}};
    for (const double y : {-1.0, 0.3, 0.5, 1.5})
        CHECK_FALSE(enclose_nearby(scene, space, three, Vec3(0, y, 0.4 + 0.5 * y * y)));
}

}  // namespace vcell::check
