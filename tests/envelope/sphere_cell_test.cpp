// Cells of spheres, from scenes to patches: curves, loops, names, and the faces against brute force.
#include <doctest/doctest.h>

#include <optional>
#include <random>

#include "../../core/errors.hpp"
#include "radial_cell_checks.hpp"

namespace vcell::sphere_cell_test {
using namespace vcell::testing;
using namespace vcell::radial_cells;

TEST_CASE("sphere cell: curves, trims and loops fit together in random scenes") {
    std::mt19937_64 rng(test_seed());
    SceneMaker make{rng};
    for (int i = 0; i < 60; ++i) {
        CAPTURE(i);
        std::optional<Cell> cell;
        while (!cell) {
            try {
                cell = cell_of(make.scene(1 + i % 15,
                                          i % 3 == 0   ? 4
                                          : i % 3 == 1 ? 20
                                                       : 100,
                                          0.15, i % 4 == 0));
            } catch (const InputError& error) {
                REQUIRE(error.kind == InputError::Kind::TouchesBase);
            }
        }
        check_cell(*cell, 1e-8);  // some are as narrow as that asks for
        check_faces_by_rays(*cell, rng, 3);
    }
}

TEST_CASE("sphere cell: with cylinders") {
    std::mt19937_64 rng(test_seed());
    SceneMaker make{rng};
    for (int i = 0; i < 6; ++i) {
        Scene scene = make.scene(4, 12, 0.2, false);
        const auto& [center, radius] = base_sphere(scene);
        for (int k = 0; k < 2; ++k) {
            const Vec3 direction = make.vector(1).normalized();
            const double rho = make.number(0.1, 1);
            scene.objects.push_back(Cylinder{center + direction * (radius + rho + make.number(0.2, 1)),
                                             direction.unitOrthogonal(), rho});
        }
        CAPTURE(i);
        const Cell cell = cell_of(scene);
        check_cell(cell, 1e-8);
        check_faces_by_rays(cell, rng, 3);
    }
}

TEST_CASE("sphere cell: points on a cube's faces give the cube") {
    std::vector<Object> points;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-2.0, 2.0}) points.push_back(Sphere{side * Vec3::Unit(axis), 0});
    const Cell cell = cell_of(centred(0, 5, points));
    check_cell(cell);
    CHECK(cell.vertices.size() == 8);
    REQUIRE(cell.edges.size() == 12);
    for (const CellEdge& edge : cell.edges) {
        CHECK(edge.kind == CurveKind::Line);
        CHECK((edge.curve.evaluate(0) - edge.curve.evaluate(1)).norm() == doctest::Approx(2).epsilon(1e-14));
    }
    for (const CellFace& face : cell.faces) {
        CHECK(face.bisector == "plane");
        CHECK(face.patches[0].surface.degree_u == 1);
    }
}

TEST_CASE("sphere cell: a small ball between two big ones has an edge without vertices") {
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(1, 2, -2)}) {
        const Vec3 c = 4 * axis / axis.norm();
        const Cell cell = cell_of(centred(0.5, 40, {Sphere{c, 3.4}, Sphere{-c, 3.4}}));
        check_cell(cell);
        const auto between = kinds_between(cell, Site::object(0), Site::object(1));
        REQUIRE(between.size() == 1);
        CHECK(between[0] == CurveKind::Circle);
        REQUIRE(cell.edges.size() == 1);
        CHECK(cell.edges[0].vertices.empty());
        REQUIRE(cell.faces.size() == 2);
    }
}

TEST_CASE("sphere cell: an island makes a hole") {
    // A small ball before a plane: its face is an island in the plane's.
    const Cell cell = cell_of(centred(1, 6, {Plane{{0, 0, 3}, {0, 0, 1}}, Sphere{{0.1, 0, 1.6}, 0.2}}));
    check_cell(cell);
    const auto plane = std::ranges::find(cell.faces, Site::object(0), &CellFace::site);
    REQUIRE(plane != cell.faces.end());
    CHECK(plane->bisector == "paraboloid");
    CHECK(plane->patches[0].loops.size() == 2);
    const auto ball = std::ranges::find(cell.faces, Site::object(1), &CellFace::site);
    REQUIRE(ball != cell.faces.end());
    CHECK(ball->bisector == "hyperboloid");
}

TEST_CASE("sphere cell: conics by their names") {
    const auto kind = [](std::vector<Object> objects, Site a, Site b) {
        const Cell cell = cell_of(centred(1, 8, std::move(objects)));
        check_cell(cell);
        const auto kinds = kinds_between(cell, a, b);
        REQUIRE_FALSE(kinds.empty());
        for (const CurveKind k : kinds) CHECK(k == kinds.front());
        return kinds.front();
    };
    const Site first = Site::object(0), second = Site::object(1);
    const Site left = Site::box_side(0), front = Site::box_side(2), back = Site::box_side(3);
    // A paraboloid cut by the box: along its axis, across it, and in between.
    CHECK(kind({Plane{{3, 0, 0}, {1, 0, 0}}}, first, back) == CurveKind::Parabola);
    CHECK(kind({Plane{{2, 0, 0}, {1, 0, 0}}}, first, left) == CurveKind::Circle);
    CHECK(kind({Plane{{2, 0, 0}, {1, 1, 0}}}, first, front) == CurveKind::Ellipse);
    // A hyperboloid cut along its axis.
    CHECK(kind({Sphere{{3, 0, 0}, 0.5}}, first, back) == CurveKind::Hyperbola);
    // Two hyperboloids: |c|^2 is more than, equal to, less than twice delta^2.
    CHECK(kind({Sphere{{5, 5, 0}, 5.5}, Sphere{{5, -5, 0}, 5.5}}, first, second) == CurveKind::Hyperbola);
    CHECK(kind({Sphere{{5, 5, 0}, 6}, Sphere{{5, -5, 0}, 6}}, first, second) == CurveKind::Parabola);
    CHECK(kind({Sphere{{5, 5, 0}, 6.5}, Sphere{{5, -5, 0}, 6.5}}, first, second) == CurveKind::Ellipse);
    // Bisectors of equal balls are planes.
    CHECK(kind({Sphere{{3, 0, 0}, 1}, Sphere{{0, 3, 0}, 1}}, first, second) == CurveKind::Line);
    CHECK(kind({Sphere{{3, 0, 0}, 1}, Sphere{{0, 3, 0}, 0.5}}, first, second) == CurveKind::Hyperbola);
}

TEST_CASE("sphere cell: faces that reach far have one patch") {
    // The balls' faces turn almost a half sphere each before the box cuts them.
    for (const double extent : {10.0, 30.0, 100.0}) {
        const Cell cell =
            cell_of(centred(1, extent, {Sphere{{2, 0.3, 0}, 0.4}, Sphere{{-1.5, 0.1, 0.2}, 1.2}}));
        check_cell(cell);
        std::mt19937_64 rng(test_seed());
        check_faces_by_rays(cell, rng, 20);
    }
}

}  // namespace vcell::sphere_cell_test
