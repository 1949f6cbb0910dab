// Cells of cylinders, from scenes to patches: faces all around, lines, conics, lattices of tubes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <set>

#include "radial_cell_checks.hpp"

namespace vcell::cylinder_cell_test {
using namespace vcell::testing;
using namespace vcell::radial_cells;

TEST_CASE("cylinder cell: a tube alone in its box") {
    const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitZ(), 1}, 4, {}));
    CHECK(cell.faces.size() == 4);
    for (const CellEdge& edge : cell.edges) CHECK(edge.kind == CurveKind::Line);
    checked(about_tube({Vec3(1, 2, 3), Vec3(1, 2, 2), 0.5}, 6, {}));
}

TEST_CASE("cylinder cell: objects of each kind") {
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 1};
    checked(about_tube(tube, 5, {Sphere{{3, 0, 1}, 0.5}}));
    checked(about_tube(tube, 5, {Sphere{{3, 0, 1}, 1}, Sphere{{0, -3, -1}, 1.5}}));
    checked(about_tube(tube, 5, {Plane{{3, 0, 0}, {1, 0, 0}}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 0, 1}, 0.7}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 0, 1}, 1}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 1, 0.3}, 0.7}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 1, 0.3}, 1}}));
}

TEST_CASE("cylinder cell: faces that go all around are cut along generators") {
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 0.5};
    // A plane across the axis beyond the upper end.
    const auto wraps = [](const Cell& cell, Site site) {
        const auto face = std::ranges::find(cell.faces, site, &CellFace::site);
        REQUIRE(face != cell.faces.end());
        CHECK(face->patches.size() >= 2);
        return *face;
    };
    CHECK(wraps(checked(about_tube(tube, 4, {Plane{{0, 0, 4.5}, {0.1, 0, 1}}})), Site::object(0)).bisector ==
          "elliptic cone");
    CHECK(wraps(checked(about_tube(tube, 4, {Plane{{0, 0, 4.5}, {0, 0, 1}}})), Site::object(0)).bisector ==
          "circular cone");
    CHECK(wraps(checked(about_tube(tube, 4, {Sphere{{0.1, 0, 8}, 3.7}})), Site::object(0)).bisector ==
          "quartic");
    // Axes that meet beyond the end, radii different: the singular lines of either sign of d lie on one half
    // each.
    CHECK(wraps(checked(about_tube(tube, 4, {Cylinder{{0, 0, 6}, {1, 0, 0}, 1.5}})), Site::object(0))
              .bisector == "quartic");
    CHECK(wraps(checked(about_tube(tube, 4, {Cylinder{{0, 0.2, 6}, {1, 0, 0.5}, 1.5}})), Site::object(0))
              .bisector == "quartic");
}

TEST_CASE("cylinder cell: between two planes that lean across it there is a conic all around") {
    // Its pieces are as long as a half turn, from one seam of the chart to the other.
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 0.2};
    const Plane roof{{0, 0, 4.5}, {0.1, 0.2, -1}};
    for (const Plane& ground : {Plane{{0, 0, -4.5}, {-0.2, 0.1, 1}}, Plane{{0, 0, -4.25}, {0.3, 0.1, 1}},
                                Plane{{0, 0, -4.5}, {0.1, 0.2, 1}}, Plane{{0, 0, -4.5}, {0, 0, 1}}}) {
        // Sides of the box are farther away than the planes are.
        Scene scene = about_tube(tube, 4, {roof, ground});
        scene.box = {{-12, -12, -4}, {12, 12, 4}};
        const Cell cell = checked(scene);
        int around = 0;
        for (const CellEdge& edge : cell.edges) {
            if (!edge.sites[0].is_object() || !edge.sites[1].is_object()) continue;
            CHECK(edge.vertices.empty());
            CHECK(edge.kind == CurveKind::Ellipse);
            double turn = 0;
            Vec3 last = edge.curve.evaluate(0);
            constexpr int samples = 200;
            for (int i = 1; i <= samples; ++i) {
                const Vec3 p = edge.curve.evaluate(i / double(samples));
                turn += std::remainder(std::atan2(p.y(), p.x()) - std::atan2(last.y(), last.x()),
                                       2 * std::numbers::pi);
                last = p;
            }
            CHECK(std::abs(turn) == doctest::Approx(2 * std::numbers::pi));
            ++around;
        }
        CHECK(around == 1);
    }
}

TEST_CASE("cylinder cell: tubes along it meet in lines") {
    for (const Vec3& axis : {Vec3(0, 1, 0), Vec3(3, 4, 0), Vec3(1, 1, 0), Vec3(-1, 0.3, 2)}) {
        CAPTURE(axis.transpose());
        const Vec3 u = axis.unitOrthogonal(), v = axis.normalized().cross(u);
        const Cell cell =
            checked(about_tube({Vec3::Zero(), axis, 0.5}, 4,
                               {Cylinder{2 * u, axis, 0.25}, Cylinder{2 * v - u, -2 * axis, 0.5},
                                Cylinder{-u - 2 * v, axis, 0.75}}));
        int lines = 0;
        for (const CellEdge& edge : cell.edges) {
            if (!edge.sites[0].is_object() || !edge.sites[1].is_object()) continue;
            CHECK(edge.kind == CurveKind::Line);
            ++lines;
        }
        CHECK(lines == 3);
        for (const CellFace& face : cell.faces)
            if (face.site.is_object())
                CHECK(face.bisector == (face.site == Site::object(1) ? "plane" : "hyperbolic cylinder"));
    }
}

TEST_CASE(
    "ball cell: a tube that reaches through the edge of two others has a face as thin as doubles hold") {
    // Around the ball the three corners of a square touch in (-1/2, -1/2, 0). The middle one, nearer by a in
    // x and y, is nearest where |z| < sqrt(2 a (1 - a) / (1 - 2 a)) on the edge of the others, (-c, -c, z), c
    // = (1 - z^2) / 2.
    for (const double radius : {0.0, 0.2})
        for (const int digits : {4, 8, 12, 20, 28, 36, 44, 60}) {
            CAPTURE(radius);
            CAPTURE(digits);
            const double a = std::ldexp(1.0, -digits);
            for (const double side : {1.0, -1.0}) {
                const auto tube = [&](double x, double y) {
                    return Cylinder{{x, y, 0}, Vec3::UnitZ(), radius};
                };
                const double corner = side * a - 1;
                if (side * a != corner + 1) continue;
                const Scene s =
                    centred(radius, 2, {tube(corner, corner), tube(-1, 0), tube(0, -1), tube(1, 1)});
                const Cell cell = cell_of(s);
                check_cell(cell);
                CHECK(cell.report.decisions.assumed == 0);
                const Site middle = Site::object(0);
                CHECK(std::ranges::count(cell.faces, middle, &CellFace::site) == (side > 0));
                int ends = 0, edges = 0;
                const double z = std::sqrt(2 * a * (1 - a) / (1 - 2 * a)), c = 0.5 * (1 - z * z);
                for (const CellVertex& v : cell.vertices) {
                    if (std::ranges::find(v.sites, middle) == v.sites.end()) continue;
                    ++ends;
                    CHECK((v.point - Vec3(-c, -c, std::copysign(z, v.point.z()))).norm() <= v.error + 1e-14);
                    CHECK(v.error < 1e-9);
                }
                for (const CellEdge& e : cell.edges) edges += e.sites[0] == middle || e.sites[1] == middle;
                CHECK(ends == 2 * (side > 0));
                CHECK(edges == 2 * (side > 0));
            }
        }
}

TEST_CASE(
    "cylinder cell: a tube that leans towards the edge of two others along it has a face as narrow as it "
    "leans") {
    // Three corners of a square meet in a line, but the middle one leans by little: it is nearest where z >
    // 0.
    for (const double radius : {0.0, 0.2})
        for (const int digits : {10, 20, 30, 38, 42}) {
            CAPTURE(radius);
            CAPTURE(digits);
            const double lean = std::ldexp(1.0, -digits);
            const auto along = [&](double x, double y) { return Cylinder{{x, y, 0}, Vec3::UnitZ(), radius}; };
            const Cell cell = cell_of(about_tube(
                {Vec3::Zero(), Vec3::UnitZ(), radius}, 2,
                {Cylinder{{-1, -1, 0}, {lean, lean, 1}, radius}, along(-1, 0), along(0, -1), along(1, 0.5)}));
            check_cell(cell);
            CHECK(cell.report.decisions.assumed == 0);
            const Site middle = Site::object(0);
            CHECK(std::ranges::count(cell.faces, middle, &CellFace::site) == 1);
            int inner = 0, on_rim = 0;
            for (const CellVertex& v : cell.vertices) {
                if (std::ranges::find(v.sites, middle) == v.sites.end()) continue;
                const bool is_end = std::abs(v.point.z()) > 1;
                (is_end ? on_rim : inner)++;
                CHECK((v.point - Vec3(-0.5, -0.5, is_end ? 2 : 0)).norm() <= v.error + 8 * lean);
            }
            CHECK(inner == 1);
            CHECK(on_rim == 2);
        }
}

TEST_CASE(
    "cylinder cell: a face all but pinched off between two others is divided where they meet, however "
    "little") {
    // Three corners of a square of balls around a tube as thick touch in (-1/2, 1/2, 0). Farther away by a in
    // x and y the middle one leaves the others the arc |z| <= sqrt(2 a (1 + a) / (1 + 2 a)) of their edge,
    // (-c, c, z), c = (1 + z^2) / 2.
    for (const double radius : {0.0, 0.25})
        for (const int digits : {4, 10, 20, 30, 36, 44}) {
            CAPTURE(radius);
            CAPTURE(digits);
            const double a = std::ldexp(1.0, -digits);
            for (const double side : {1.0, -1.0}) {
                CAPTURE(side);
                const double corner = 1 + side * a;
                const auto ball = [&](double x, double y) { return Sphere{{x, y, 0}, radius}; };
                const Cell cell =
                    cell_of(about_tube({Vec3::Zero(), Vec3::UnitZ(), radius}, 2,
                                       {ball(-corner, corner), ball(-1, 0), ball(0, 1), ball(1, -1)}));
                check_cell(cell);
                CHECK(cell.report.decisions.assumed == 0);
                const auto meet = [](const auto& sites, std::initializer_list<std::uint32_t> objects) {
                    return std::ranges::all_of(objects, [&](std::uint32_t i) {
                        return std::ranges::find(sites, Site::object(i)) != sites.end();
                    });
                };
                const double z = std::sqrt(2 * a * (1 + a) / (1 + 2 * a)), c = 0.5 * (1 + z * z);
                int ends = 0;
                for (const CellVertex& v : cell.vertices) {
                    if (!meet(v.sites, {0, 1, 2})) continue;
                    ++ends;
                    CHECK((v.point - Vec3(-c, c, std::copysign(z, v.point.z()))).norm() <= v.error + 1e-14);
                }
                CHECK(ends == 2 * (side > 0));
                CHECK(std::ranges::count_if(cell.edges, [](const CellEdge& e) {
                          return e.sites == std::array{Site::object(1), Site::object(2)} ||
                                 e.sites == std::array{Site::object(2), Site::object(1)};
                      }) == (side > 0));
            }
        }
}

TEST_CASE("cylinder cell: in lattices of tubes along it four meet in a line") {
    const std::array<std::array<Vec3, 3>, 5> lattices{
        {{Vec3(0, 0, 1), Vec3(2, 0, 0), Vec3(0, 2, 0)},
         {Vec3(0, -3, 0), Vec3(0, 0, 2), Vec3(1.5, 0, 0)},
         {Vec3(1, 1, 0), Vec3(1.5, -1.5, 0), Vec3(0, 0, 2)},
         {Vec3(1, 1, 0), Vec3(1.5, -1.5, 1.5), Vec3(1.5, -1.5, -3)},
         {Vec3(2, 3, 6), Vec3(3, -6, 2), Vec3(6, 2, -3)}}};
    for (const auto& [axis, u, v] : lattices)
        for (const double radius : {0.0, 0.5}) {
            CAPTURE(axis.transpose());
            CAPTURE(radius);
            std::vector<Object> tubes;
            for (const int i : {-1, 0, 1})
                for (const int j : {-1, 0, 1})
                    if (i != 0 || j != 0) tubes.push_back(Cylinder{i * u + j * v, axis, radius});
            const auto check_lattice = [&](const Scene& scene) {
                const Cell cell = checked(scene);
                CHECK(cell.report.decisions.assumed == 0);
                std::set<Site> extra;
                for (const CellEdge& edge : cell.edges)
                    if (!edge.extra_sites.empty()) {
                        CHECK(edge.kind == CurveKind::Line);
                        REQUIRE(edge.extra_sites.size() == 1);
                        extra.insert(edge.extra_sites.front());
                        for (const std::uint32_t w : edge.vertices)
                            CHECK(std::ranges::find(cell.vertices[w].sites, edge.extra_sites.front()) !=
                                  cell.vertices[w].sites.end());
                    }
                // The corners.
                CHECK(extra == std::set{Site::object(0), Site::object(2), Site::object(5), Site::object(7)});
            };
            check_lattice(about_tube({Vec3::Zero(), axis, radius}, 9, tubes));
            tubes.push_back(Sphere{0.625 * u + 0.125 * v, 0.25});
            check_lattice(about_tube({Vec3::Zero(), axis, radius}, 9, tubes));
        }
}

TEST_CASE("cylinder cell: in lattices with holes and rounded coordinates more tubes meet in a line") {
    const double h = 0.5 * std::numbers::sqrt3;
    const Vec3 u(0, 1, 0), v(0, 0.5, h);
    // Around u + v, the two thirds of a hexagon's corners that are left.
    for (const double radius : {0.0, 0.1}) {
        CAPTURE(radius);
        std::vector<Object> tubes;
        for (const int i : {-2, -1, 0, 1, 2})
            for (const int j : {-2, -1, 0, 1, 2})
                if ((i != 0 || j != 0) && (i != 1 || j != 0))
                    tubes.push_back(Cylinder{i * u + j * v, Vec3::UnitX(), radius});
        const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitX(), radius}, 4, tubes));
        std::size_t most = 0;
        for (const CellEdge& edge : cell.edges) most = std::max(most, edge.extra_sites.size());
        CHECK(most == 3);  // five tubes and the base on a circle about the hole
        CHECK(cell.report.decisions.assumed == 1);
        REQUIRE(cell.report.warnings.size() == 1);
        CHECK(cell.report.warnings[0].find("taken to meet in one line through") != std::string::npos);
    }
    // The directions in which four tubes of a square lattice tie with the hole at one of them.
    std::vector<Object> square;
    for (const int i : {-2, -1, 0, 1, 2})
        for (const int j : {-2, -1, 0, 1, 2})
            if ((i != 0 || j != 0) && (i != 1 || j != 0) && (i != 0 || j != 1))
                square.push_back(Cylinder{{double(i), 0, double(j)}, Vec3::UnitY(), 0.25});
    const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitY(), 0.25}, 4, square));
    CHECK(cell.report.decisions.assumed == 0);
}

TEST_CASE("cylinder cell: a line into corners, edges and sides of the box, and planes through its ends") {
    const auto wall = [](int k, double at) { return Plane{at * Vec3::Unit(k), Vec3::Unit(k)}; };
    for (const Vec3& axis :
         {Vec3(1, 1, 1), Vec3(-1, 1, 1), Vec3(1, 2, 2), Vec3(3, 1, 3), Vec3(1, 1, 0), Vec3(1, 2, 3)})
        for (const double radius : {0.0, 1e-12, 1e-6, 1e-3}) {
            CAPTURE(axis.transpose());
            CAPTURE(radius);
            const Cell cell = checked(about_tube({Vec3::Zero(), axis, radius}, 1, {}));
            CHECK(cell.faces.size() == 6);
            CHECK(cell.report.decisions.assumed == 0);
            for (const CellEdge& edge : cell.edges) CHECK(edge.kind == CurveKind::Line);
            // The sides where it ends, as planes too. (In (1, 1, 0) a side touches the edge between them.)
            if (radius > 0 || axis.z() == 0) continue;
            int k = 0;
            axis.cwiseAbs().maxCoeff(&k);
            const Cell walled = checked(about_tube({Vec3::Zero(), axis, 0}, 1, {wall(k, 1), wall(k, -1)}));
            CHECK(std::ranges::count_if(walled.faces, [](const CellFace& f) { return f.site.is_object(); }) ==
                  2);
            for (const CellEdge& edge : walled.edges) {
                CHECK(edge.kind != CurveKind::Spline);
                CHECK(edge.error <= 1e-11);
            }
        }
    // Past a corner by little, with a plane through it: cones whose tips all but agree meet in hyperbolas.
    for (const double past : {1e-3, 1e-6, 1e-9, 1e-12}) {
        CAPTURE(past);
        const Cell cell = checked(about_tube({Vec3::Zero(), {1, 1 - past, 1 + past / 3}, 0}, 1,
                                             {Plane{{1, 1, 1}, {1, 0.3, 0}}, wall(2, -1)}));
        CHECK(cell.report.decisions.assumed == 0);
        for (const CellEdge& edge : cell.edges) CHECK(edge.kind != CurveKind::Spline);
    }
    // In a corner of planes the cones about the line meet in lines through it.
    const Cell corner =
        checked(about_tube({Vec3::Zero(), {1, 1, 1}, 0}, 1, {wall(0, 1), wall(1, 1), wall(2, 1)}));
    int lines = 0;
    for (const CellEdge& edge : corner.edges) {
        CHECK(edge.kind != CurveKind::Spline);
        if (edge.sites[0].is_object() && edge.sites[1].is_object()) lines += edge.kind == CurveKind::Line;
    }
    CHECK(lines == 3);
    checked(about_tube({Vec3::Zero(), {1, 1, 1}, 0}, 1,
                       {Sphere{{0.5, 0, 0}, 0.1}, Cylinder{{0, 0.5, -0.5}, {1, 0, 0}, 0.05},
                        Plane{{1, 1, 1}, {1, -1, 0.5}}}));
}

TEST_CASE("cylinder cell: planes, sides of the box and tubes along it meet in conics, exactly") {
    const auto kind = [](const Cell& cell, Site f, Site g) {
        std::optional<CurveKind> found;
        for (const CellEdge& edge : cell.edges) {
            CHECK(edge.kind != CurveKind::Spline);
            CHECK(edge.error <= 1e-11);
            if ((edge.sites[0] == f && edge.sites[1] == g) || (edge.sites[0] == g && edge.sites[1] == f))
                found = edge.kind;
        }
        REQUIRE(found);
        return *found;
    };
    const Site first = Site::object(0), second = Site::object(1), top = Site::end(1);
    const Cylinder tube{Vec3::Zero(), {0, 0, 1}, 0.5};
    const auto plane = [](double x, double y, double rise) {
        return Plane{{2 * x, 2 * y, 0}, {-x, -y, rise}};
    };
    Cell cell = checked(about_tube(tube, 3, {plane(1, 0, 0.125), plane(0, 1, -0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Ellipse);
    cell = checked(about_tube(tube, 3, {plane(1, 0, 0.125), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Hyperbola);
    CHECK(kind(cell, first, top) == CurveKind::Ellipse);
    CHECK(kind(cell, first, Site::box_side(2)) == CurveKind::Hyperbola);
    // Cones with one apex; planes along the axis; a plane across it, all around and beside a tube.
    cell = checked(about_tube(tube, 3, {plane(1, 0, 0.25), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Line);
    cell = checked(about_tube(tube, 3, {plane(1, 0, 0), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, top) == CurveKind::Parabola);
    // The length of a normal need not be a double for a parabola to be one.
    cell = checked(about_tube(tube, 3, {plane(1, 1, 0), plane(-1, 0, 0.25)}));
    CHECK(kind(cell, first, top) == CurveKind::Parabola);
    cell = checked(about_tube(tube, 3, {plane(1, 1, 0), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Parabola);
    cell = checked(about_tube(tube, 3, {Plane{{0, 0, 4}, {0, 0, 1}}}));
    CHECK(kind(cell, first, top) == CurveKind::Circle);
    cell = checked(about_tube(tube, 3, {Plane{{0, 0, 4}, {0, 0, 1}}, Cylinder{{2, 0, 0}, {0, 0, 1}, 0.25}}));
    CHECK(kind(cell, first, second) == CurveKind::Hyperbola);
    CHECK(kind(cell, second, top) == CurveKind::Hyperbola);
    // All around in sectors, tilted, around a line.
    for (const Vec3& axis : {Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(-1, 0.3, 2)})
        for (const double radius : {0.0, 0.5}) {
            CAPTURE(axis.transpose());
            const Vec3 u = axis.unitOrthogonal(), v = axis.normalized().cross(u), w = axis.normalized();
            kind(checked(about_tube({Vec3::Zero(), axis, radius}, 4,
                                    {Plane{2 * u, u + 0.25 * w}, Cylinder{-2 * u - v, axis, 0.5},
                                     Plane{1.5 * v, v - 0.125 * w}})),
                 first, second);
        }
}

}  // namespace vcell::cylinder_cell_test
