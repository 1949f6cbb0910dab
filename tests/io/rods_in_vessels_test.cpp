// Rods in pipes and silos: faces on both sides of the tips that their bisectors with hollow tubes and cones
// have, proved, and what is made of them.
#include <doctest/doctest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../test_support.hpp"
#include "boxed_scenes.hpp"
#include "closed_meshes.hpp"
#include "listing.hpp"

using namespace vcell;

namespace {

std::size_t patches_of(const Cell& cell, std::uint32_t object) {
    std::size_t count = 0;
    for (const CellFace& face : cell.faces)
        if (face.site == Site::object(object)) count += face.patches.size();
    return count;
}

}  // namespace

// The wall's face runs around the rod: next to the half plane in which the line from the tip runs to where
// the rod's axis comes out of the wall, and another line from there on, it has two sectors at one place. From
// the apex the tip is (d - r) / S away and that place (K d - r) / S, d the rod's way from the axis.
TEST_CASE("rods in vessels: a rod along the axis of a cone, next to it") {
    const double S = 0.4, K = std::sqrt(1 - S * S), bottom = -1.5;
    for (const double radius : {0.0, 0.25})
        for (const double aside : {0.375, 0.75}) {
            CAPTURE(radius);
            CAPTURE(aside);
            const double out = bottom - 0.03, apex = out - (K * aside - radius) / S;
            Scene scene = scene_in_cube(Cylinder{{aside, 0, 0}, {0, 0, 1}, radius},
                                        {HollowCone{{0, 0, apex}, {0, 0, 1}, 3, 7.5}}, 4);
            scene.box.min.z() = bottom;
            const Cell cell = voronoi_cell(scene);
            check_holds(cell);
            CHECK(patches_of(cell, 0) == 5);
            check_mesh_and_solid(cell, 1e-2);
        }
}

// Both tips lie in one face where nothing else is near: all of the bisector but two places.
TEST_CASE("rods in vessels: rods across a pipe and a cone") {
    const Object pipe = HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1},
                 cone = HollowCone{{0, 0, -3}, {0, 0, 1}, 3, 5};
    for (const Object& vessel : {pipe, cone})
        for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(1, 0, 0.5), Vec3(1, 0.25, -1)})
            for (const double aside : {0.0, 0.375}) {
                CAPTURE(axis.transpose());
                CAPTURE(aside);
                Scene scene = scene_in_cube(Cylinder{{0, aside, 0}, axis, 0.125}, {vessel}, 4);
                scene.box.min.x() = -0.75;
                scene.box.max.x() = 0.625;
                const Cell cell = voronoi_cell(scene);
                check_holds(cell);
                CHECK(patches_of(cell, 0) >= 2);
                check_mesh_and_solid(cell, 1e-2);
            }
}

TEST_CASE("rods in vessels: a tip that a ball hides, and one that a side of the box cuts off") {
    const HollowCylinder pipe{{0, 0, 0}, {0, 0, 1}, 1};
    const Cylinder rod{{0, 0.0625, 0}, {1, 0.125, 0.5}, 0.125};
    for (const bool is_ball : {false, true}) {
        std::vector<Object> objects{pipe};
        if (is_ball) objects.push_back(Sphere{{0, 0, 1.25}, 0.25});
        Scene scene = scene_in_cube(rod, objects, 3);
        scene.box.min.x() = -0.75;
        scene.box.max.x() = 0.75;
        if (!is_ball) scene.box.max.z() = 1;
        const Cell cell = voronoi_cell(scene);
        check_holds(cell);
        check_mesh_and_solid(cell, 1e-2);
    }
}

TEST_CASE("rods in vessels: random rods among balls and rods are proved") {
    RandomPlaces r;
    int proved = 0, open = 0, undecided = 0;
    const int count = long_rounds(40);
    for (int round = 0; round < count; ++round) {
        CAPTURE(round);
        const Vec3 lean = Vec3(0, 0, 1) + r.uniform(0, 0.75) * r.place(1);
        const Object vessel = round % 2 == 0 ? Object(HollowCylinder{r.place(0.25), lean, r.uniform(1, 2)})
                                             : Object(HollowCone{{0, 0, -3}, lean, r.uniform(1.5, 3), 5});
        std::vector<Object> objects{vessel};
        for (int i = r.count(0, 3); i > 0; --i) {
            const Vec3 place = r.place(2);
            if (i % 2 == 0)
                objects.push_back(Sphere{place, r.uniform(0, 0.5)});
            else
                objects.push_back(Cylinder{place, r.direction(), r.uniform(0, 0.2)});
        }
        const Vec3 axis = round % 3 == 0 ? Vec3(0, 0, 1) : Vec3(Vec3(0, 0, 1) + 0.75 * r.place(1));
        const double radius = round % 5 == 0 ? 0 : r.uniform(0, 0.3);
        Scene scene = scene_in_cube(Cylinder{r.place(0.5), axis, radius}, objects, 2);
        scene.box.min.z() = -r.uniform(0.25, 1.5);
        scene.box.max.z() = r.uniform(0.25, 1.5);
        try {
            const Certificate certificate = certify(voronoi_cell(scene));
            CHECK_MESSAGE(certificate.count(Verdict::refuted) == 0, listing(certificate));
            // As beside the slab in which a line runs through a side of the box.
            ++(certificate.holds() ? proved : open);
        } catch (const InputError& e) {
            // The rod, or another one through it, comes out of the vessel.
            CHECK((e.kind == InputError::Kind::TouchesBase || e.kind == InputError::Kind::EmptyBox));
        } catch (const UndecidedError& e) {
            ++undecided;
        }
    }
    CHECK(3 * proved >= count);
    CHECK(32 * open <= count);
    CHECK(32 * undecided <= count);
}

// Where a line runs into a side of the box obliquely its cell ends in edges 1e-7 around it, of which a
// rounding is much of a turn; in the first scene the wall comes down to the line there, too.
TEST_CASE("rods in vessels: what lies between edges next to a line is told from these") {
    const HollowSphere wall{{0, 0, 0}, 6};
    const HollowCylinder pipe{{0, 0, 0}, {-1, 2, 1}, 3.5};
    const Plane floor{{0, 0, 2}, {0, 0, 1}};
    const Sphere dot{{0, 0, -1}, 0};
    const auto cell = [](const Vec3& axis, std::vector<Object> objects) {
        return voronoi_cell(scene_in_cube(Cylinder{{0, 0, 0}, axis, 0}, std::move(objects), 4));
    };
    check_holds(cell({1, 2, 2}, {wall}));
    check_holds(cell({-2, -1, 1}, {HollowSphere{{1, -2, -1}, 6}, floor}));
    check_holds(cell({-1, 2, 1}, {pipe, dot, floor}));
    check_holds(cell({-1, 2, 1}, {dot, Plane{{0, 0, -1}, {1, 0, 2}}}));
}
