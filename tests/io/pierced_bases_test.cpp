// Balls and tubes that thinner tubes run through next to their centre or axis, as sticks do through balls and
// fibres through thick ones: proved cells, whole diagrams, a volume in one variable.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../../io/check/check.hpp"
#include "../envelope/diagram_checks.hpp"
#include "../test_support.hpp"
#include "boxed_scenes.hpp"
#include "closed_meshes.hpp"
#include "listing.hpp"
#include "stored_diagrams.hpp"

using namespace vcell;

namespace {

struct Random : RandomPlaces {
    /// Through what has this radius and this axis, if it has one.
    Cylinder thin_tube(double radius, const Vec3& axis) {
        for (;;) {
            const Cylinder tube{place(radius), direction(), uniform(0, 0.6 * radius)};
            const Vec3 aside = axis.isZero(0) ? tube.point - tube.axis.dot(tube.point) * tube.axis
                                              : tube.axis.cross(axis).normalized();
            const double off = axis.isZero(0) ? aside.norm() : std::abs(aside.dot(tube.point));
            if (off < 0.95 * (radius - tube.radius) &&
                tube.axis.cross(axis).norm() >= (axis.isZero(0) ? 0 : 0.2))
                return tube;
        }
    }
};

}  // namespace

TEST_CASE("pierced: cells of random balls and tubes are proved") {
    Random r;
    for (int round = 0; round < long_rounds(24); ++round) {
        CAPTURE(round);
        const Vec3 axis = round % 3 == 0   ? Vec3(Vec3::Zero())
                          : round % 3 == 1 ? Vec3(Vec3::UnitZ())
                                           : r.direction();
        std::vector<Object> objects;
        for (int i = 0; i < 1 + round % 4; ++i) objects.push_back(r.thin_tube(1, axis));
        for (int i = 0; i < 3; ++i) {
            const Vec3 center = r.place(4);
            if (center.norm() > 2) objects.push_back(Sphere{center, r.uniform(0, 0.5)});
        }
        const Object base =
            axis.isZero(0) ? Object(Sphere{Vec3::Zero(), 1}) : Object(Cylinder{Vec3::Zero(), axis, 1});
        try {
            check_holds(voronoi_cell(scene_in_cube(base, objects, 5)));
        } catch (const InputError& e) {
            CHECK(e.kind == InputError::Kind::TouchesBase);  // a ball in the base
        }
    }
}

TEST_CASE("pierced: faces of a tube on both sides of a tip that another tube hides are proved, too") {
    const Cylinder thick{Vec3::Zero(), Vec3::UnitZ(), 1}, thin{{0, 0.25, 0.125}, {1, 0.25, 0.5}, 0.25};
    // About the same place of the axis, and thicker: the tip of the other one is in it.
    const Sphere bead{{0.8, 0.45, 0.525}, 0.5};
    for (const bool is_hidden : {false, true}) {
        std::vector<Object> objects{thin};
        if (is_hidden) objects.push_back(bead);
        const Cell cell = voronoi_cell(scene_in_cube(thick, objects, 4));
        check_holds(cell);
        const auto face = std::ranges::find(cell.faces, Site::object(0), &CellFace::site);
        REQUIRE(face != cell.faces.end());
        CHECK(face->patches.size() >= 2);
        const double least = cell.measures.min_clearance;
        if (is_hidden)
            CHECK(least < -0.26);
        else
            CHECK(least == doctest::Approx(-0.25).epsilon(1e-13));
    }
}

// In a hollow sphere about the same centre the stick through a ball has, at the distance t, the two caps in
// which the sine of the angle from its axis is less than 1 - (R - r) / t.
TEST_CASE("pierced: a ball's volume around a stick through its centre") {
    constexpr double R = 1, stick = 0.25, wall = 4, D = R - stick, T = 0.5 * (R + wall);
    const Vec3 center(0.5, -0.25, 0.125), axis(1, 2, -2);
    Scene scene =
        scene_in_cube(Sphere{center, R}, {Cylinder{center, axis, stick}, HollowSphere{center, wall}}, 6);
    const Cell cell = voronoi_cell(scene);
    // With t = D + x^2 the integrand is smooth at the tips.
    const double caps = boost::math::quadrature::gauss<double, 30>::integrate(
        [&](double x) {
            const double t = D + x * x, sine = x * x / t;
            return 2 * x * t * t * (sine * sine / (1 + std::sqrt(1 - sine * sine)));
        },
        0.0, std::sqrt(T - D));
    const double volume = 4 * std::numbers::pi * (T * T * T / 3 - caps);
    CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error + 1e-11);
    CHECK(cell.measures.volume_error < 1e-6);
    CHECK(cell.measures.min_clearance == doctest::Approx(-stick).epsilon(1e-13));
    check_holds(cell);
}

TEST_CASE("pierced: whole diagrams of balls, sticks through them and fibres fill their box") {
    const Sphere ball{{0, 0, 0}, 1.5}, other{{2.5, 2.5, 0}, 1};
    DiagramScene scene;
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    // From one ball to the other, through both centres, and others aside.
    scene.objects = {ball,
                     other,
                     Cylinder{{0, 0, 0}, {1, 1, 0}, 0.25},
                     Cylinder{{0.25, 0.5, 0}, {0, 1, 2}, 0.5},
                     Cylinder{{-2.5, 0, 1}, {0, 0, 1}, 0.75},
                     Cylinder{{-2.5, 0.25, -1}, {1, -2, 1}, 0.125},
                     Sphere{{-1, -3, 2}, 0.25}};
    scene.names.resize(scene.objects.size());
    const auto diagram = parse_diagram(text_of(scene, true));
    REQUIRE(diagram);
    CHECK(diagram->cells.size() == scene.objects.size());
    check_proved(certify(*diagram));
}

// Soft ones, thick and thin, through each other anyhow. What lies in another one has no cell, and neither has
// one whose axis all but touches another one from within: few scenes have such a one.
TEST_CASE("pierced: balls and fibres that cut each other fill their box") {
    Random r;
    int refused = 0;
    const int count = long_rounds(3);
    for (int round = 0; round < count; ++round) {
        CAPTURE(round);
        DiagramScene scene;
        scene.box = {Vec3::Constant(-5), Vec3::Constant(5)};
        for (int i = 0; i < 10; ++i)
            scene.objects.push_back(Cylinder{r.place(5), r.direction(),
                                             i % 3 == 0   ? 1.2
                                             : i % 3 == 1 ? 0.6
                                                          : 0.1});
        for (int i = 0; i < 5; ++i) scene.objects.push_back(Sphere{r.place(5), r.uniform(0.3, 1.5)});
        scene.names.resize(scene.objects.size());
        const VoronoiDiagram diagram = voronoi_diagram(scene);
        if (std::ranges::any_of(diagram.cells, touches_from_within)) {
            ++refused;
            continue;
        }
        for (const DiagramCell& cell : diagram.cells)
            CHECK_MESSAGE(
                (cell.state == DiagramCell::State::Computed || cell.state == DiagramCell::State::Empty),
                cell.reason);
        const FilledVolume filled = filled_volume(scene, diagram);
        CHECK(filled.fills());
        CHECK(filled.error < 1e-2);
    }
    CHECK(16 * refused <= count);
}

// Where the patches of a face come together in a tip, caps close them for programs that know no sides of one
// point.
TEST_CASE("pierced: meshes are closed around tips, and so are the loops of solids") {
    const Cylinder thin{{0, 0.25, 0.125}, {1, 0.25, 0.5}, 0.25};
    for (const Object& base : {Object(Sphere{Vec3::Zero(), 1}), Object(Cylinder{Vec3::Zero(), {0, 0, 1}, 1}),
                               Object(Cylinder{Vec3::Zero(), {-1, 2, 2}, 1})}) {
        const Cell cell = voronoi_cell(scene_in_cube(base, {thin, Sphere{{0, 3, 1}, 0.5}}, 4));
        check_mesh_and_solid(cell, 1e-2);
        const Solid solid = solid_of(closed_shell(cell), cell.faces.size());
        for (const Solid::Face& face : solid.faces)
            for (const auto& loop : face.loops)
                for (std::size_t i = 0; i < loop.size(); ++i) {
                    const Solid::Use &use = loop[i], &next = loop[(i + 1) % loop.size()];
                    CHECK(solid.edges[use.edge].vertices[use.reversed ? 0 : 1] ==
                          solid.edges[next.edge].vertices[next.reversed ? 1 : 0]);
                }
    }
}

TEST_CASE("pierced: what is not so is objected to") {
    const std::vector<Object> objects{Cylinder{{0, 0.25, 0.125}, {1, 0.25, 0.5}, 0.25}};
    for (const Object& base :
         {Object(Sphere{Vec3::Zero(), 1}), Object(Cylinder{Vec3::Zero(), {0, 0, 1}, 1})}) {
        const Cell whole = voronoi_cell(scene_in_cube(base, objects, 4));
        REQUIRE(certify(whole).holds());
        Cell cell = whole;
        SUBCASE("a thinner tube") { std::get<Cylinder>(cell.scene.objects[0]).radius -= 1e-4; }
        SUBCASE("a moved one") { std::get<Cylinder>(cell.scene.objects[0]).point.y() += 1e-4; }
        SUBCASE("the least clearance") { cell.measures.min_clearance -= 1e-4; }
        SUBCASE("a volume") { cell.measures.volume += 1e-5; }
        SUBCASE("a patch without its tip") {
            const auto face = std::ranges::find(cell.faces, Site::object(0), &CellFace::site);
            face->patches[0].loops[0].pop_back();
        }
        CHECK_FALSE(certify(cell).holds());
    }
}
