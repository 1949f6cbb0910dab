// Tubes of one radius whose axes cross, as fibres of a net do: each has two opposite wedges beside the
// crossing. Halves of cubes, proved cells, whole diagrams, meshes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../../io/check/check.hpp"
#include "../test_support.hpp"
#include "boxed_scenes.hpp"
#include "complete_checks.hpp"
#include "listing.hpp"
#include "stored_diagrams.hpp"

using namespace vcell;

// The wedges' walls are at right angles to each other, so that a quarter of a turn takes the square that the
// axes lie in to itself and the base's wedges to the other's. Each wall cuts the square half its angle from
// the base's axis.
TEST_CASE("crossing axes: half of a cube is nearest to either of two tubes through its centre") {
    RandomPlaces r;
    for (int round = 0; round < long_rounds(12); ++round) {
        const double from = r.uniform(0, M_PI), turn = round % 3 == 0 ? M_PI / 2 : r.uniform(0.05, 3.09),
                     radius = 0.25 * r.count(0, 1);
        const int normal = r.count(0, 2);
        const auto axis = [&](double angle) {
            Vec3 a = Vec3::Zero();
            a[(normal + 1) % 3] = std::cos(angle);
            a[(normal + 2) % 3] = std::sin(angle);
            return a;
        };
        CAPTURE(from);
        CAPTURE(turn);
        const Cell cell = voronoi_cell(scene_in_cube(Cylinder{Vec3::Zero(), axis(from), radius},
                                                     {Cylinder{Vec3::Zero(), axis(from + turn), radius}}, 1));
        REQUIRE(cell.is_complete);
        check_holds(cell);
        CHECK(std::abs(cell.measures.volume - 4) <= cell.measures.volume_error);
        CHECK(cell.measures.volume_error < 1e-6);
        const double cut = from + 0.5 * turn,
                     chord = 2 / std::max(std::abs(std::cos(cut)), std::abs(std::sin(cut)));
        CHECK(std::abs(cell.measures.area - 2 * chord * 2) <= cell.measures.area_error);
        CHECK(std::abs(cell.measures.box_area - 12) <= cell.measures.box_area_error);
        for (const CellFace& face : cell.faces)
            if (face.site.is_object()) CHECK(face.bisector == "plane");
    }
}

TEST_CASE("crossing axes: cells among balls and tubes, some through the same point, are proved") {
    RandomPlaces r;
    int faces = 0, open = 0;
    for (int round = 0; round < long_rounds(12); ++round) {
        CAPTURE(round);
        const double radius = 0.2 * r.count(0, 2);
        const Vec3 crossing = r.place(round % 4 == 0 ? 6 : 3);  // it may be beyond the box
        std::vector<Object> objects;
        for (int i = r.count(1, 3); i > 0; --i) objects.push_back(Cylinder{crossing, r.direction(), radius});
        for (int i = r.count(0, 4); i > 0; --i)
            objects.push_back(Sphere{r.place(4), radius + r.uniform(0, 0.2)});
        objects.push_back(Cylinder{r.place(4), r.direction(), 0.9 * radius});
        Cell cell;
        try {
            cell = complete_cell(scene_in_cube(Cylinder{crossing, r.direction(), radius}, objects, 4));
        } catch (const InputError&) {
            continue;  // another one touches it, or nothing of it is in the box
        }
        const Certificate certificate = certify(cell);
        CHECK_MESSAGE(certificate.count(Verdict::refuted) == 0, listing(certificate));
        open += certificate.holds() ? 0 : 1;
        check_complete_measures(cell, complete_measures(cell.scene), cell.measures.area_error);
        checked_mesh(cell);
        faces += static_cast<int>(cell.faces.size());
    }
    CHECK(faces > 5 * long_rounds(12));
    // Where rays come into the box the least clearance may be enclosed no better than as if they did not.
    CHECK(open <= long_rounds(12) / 48);
}

// Where two tubes cross a third one in one point of its axis each of the three has wedges.
TEST_CASE("crossing axes: whole diagrams of nets fill their box") {
    DiagramScene scene;
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    for (const double at : {-1.0, 0.0, 1.0}) {
        scene.objects.push_back(Cylinder{{0, at, 0}, {1, 0, 0}, 0.125});
        scene.objects.push_back(Cylinder{{at, 0, 0}, {0, 1, 0}, 0.125});
    }
    SUBCASE("along the box") {}
    SUBCASE("turned") {
        // By a rational turn, so that they cross as before.
        Eigen::Matrix3d turn;
        turn << 1, 2, 2, 2, 1, -2, 2, -2, 1;
        for (Object& object : scene.objects) {
            auto& tube = std::get<Cylinder>(object);
            tube.point = 0.25 * turn * tube.point;
            tube.axis = turn * tube.axis;
        }
    }
    SUBCASE("of meshes that are rounded") {
        // Three planes have each line in common but for that.
        scene.objects.clear();
        for (const double at : {-0.9, -0.5, -0.1, 0.3, 0.7}) {
            scene.objects.push_back(Cylinder{{0, at, 0}, {1, 0, 0}, 0.03});
            scene.objects.push_back(Cylinder{{at, 0, 0}, {0, 1, 0}, 0.03});
        }
    }
    SUBCASE("with others through their nodes") {
        scene.objects.push_back(Cylinder{{-1, -1, 0}, {3, -1, 2}, 0.125});
        scene.objects.push_back(Cylinder{{1, 1, 0}, {1, 2, 5}, 0.125});
        scene.objects.push_back(Sphere{{0.25, 0.5, 1}, 0.25});
    }
    scene.names.resize(scene.objects.size());
    const StoredDiagram diagram = stored(scene, true);
    CHECK(diagram.cells.size() == scene.objects.size());
    check_proved(certify(diagram));
}

// Of each two walls that are one but for rounding one is left out, and never both.
TEST_CASE("crossing axes: tubes that are one but for rounding have one cell beside them in a net") {
    const auto cell_in_net = [](double lean) {
        std::vector<Object> objects;
        for (const double at : {-0.9, -0.5, -0.1, 0.3, 0.7}) {
            if (at != -0.1) objects.push_back(Cylinder{{0, at, 0}, {1, 0, 0}, 0.03});
            objects.push_back(Cylinder{{at, 0, 0}, {0, 1, 0}, 0.03});
            if (lean != 0) objects.push_back(Cylinder{{at, -0.1, 0}, {lean, 1, 0}, 0.03});
        }
        return complete_cell(scene_in_cube(Cylinder{{0, -0.1, 0}, {1, 0, 0}, 0.03}, objects, 1));
    };
    const double volume = cell_in_net(0).measures.volume;
    for (const double lean : {1e-17, -1e-17}) {
        CAPTURE(lean);
        const Cell cell = cell_in_net(lean);
        CHECK(std::abs(cell.measures.volume - volume) <= 2 * cell.measures.volume_error);
        CHECK(certify(cell).count(Verdict::refuted) == 0);
    }
}

TEST_CASE("crossing axes: what is not so is objected to") {
    const Cell whole =
        voronoi_cell(scene_in_cube(Cylinder{{0, 1, 0}, {1, 0, 1}, 0.25},
                                   {Cylinder{{0, 1, 0}, {0, 1, 2}, 0.25}, Sphere{{2, -2, 1}, 0.5}}, 4));
    REQUIRE(certify(whole).holds());
    Cell cell = whole;
    auto& tube = std::get<Cylinder>(cell.scene.objects[0]);
    SUBCASE("axes that pass each other") { tube.point.x() += 1e-4; }
    SUBCASE("a thicker tube") { tube.radius += 1e-4; }
    SUBCASE("another direction") { tube.axis.x() += 1e-4; }
    SUBCASE("a crossing elsewhere") { tube.point += 1e-4 * Vec3(1, 0, 1); }
    SUBCASE("a volume") { cell.measures.volume += 1e-4; }
    SUBCASE("an area") { cell.faces[0].area *= 1.001; }
    CHECK_FALSE(certify(cell).holds());
}

// Beside such a place distances turn within as little as lies between the axes. A finer tolerance asks for
// edges in other parts, of which the integrals add up to the same.
TEST_CASE(
    "crossing axes: cells beside axes that all but cross are proved, and their volumes as sharp as stated") {
    RandomPlaces r;
    for (int round = 0; round < long_rounds(18); ++round) {
        const double radius = round % 3 == 0 ? 0 : 0.3;
        const bool is_upright = r.count(0, 1) == 1;
        const Cylinder base{Vec3::Zero(), is_upright ? Vec3::UnitZ() : r.direction(), radius};
        Scene scene = scene_in_cube(base, {}, 2);
        CAPTURE(round);
        for (int i = r.count(1, 2); i > 0; --i) {
            const double apart = std::pow(10, -r.uniform(1, 6));
            const Vec3 axis = r.direction(), across = base.axis.cross(axis).normalized();
            scene.objects.push_back(
                Cylinder{r.uniform(-1, 1) * base.axis.normalized() + apart * across, axis, radius});
        }
        const Cell cell = voronoi_cell(scene);
        check_holds(cell);
        scene.tolerance = 1e-7;
        const Measures &rough = cell.measures, fine = voronoi_cell(scene).measures;
        CHECK(std::abs(rough.volume - fine.volume) <= rough.volume_error + fine.volume_error);
        CHECK(std::abs(rough.area - fine.area) <= rough.area_error + fine.area_error);
    }
}
