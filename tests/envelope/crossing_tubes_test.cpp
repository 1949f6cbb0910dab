// Cells among tubes that cross, touch or are all but parallel, vertices on seams, boxes far larger than the
// cell, and random scenes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "radial_cell_checks.hpp"

namespace vcell::crossing_tubes_test {
using namespace vcell::testing;
using namespace vcell::radial_cells;

TEST_CASE("cylinder cell: crossing axes of equal radius have planes for bisectors") {
    const Cell cell =
        checked(about_tube({Vec3::Zero(), Vec3::UnitZ(), 0.5}, 4, {Cylinder{{0, 0, 6}, {1, 0, 1}, 0.5}}));
    for (const CellFace& face : cell.faces)
        if (face.site.is_object()) CHECK(face.bisector == "plane");
}

TEST_CASE("cylinder cell: a skew tube of the base's radius has a bilinear patch, or strips of one") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> at(-1, 1);
    const auto random = [&] { return Vec3(at(rng), at(rng), at(rng)); };
    // A ball and another tube end the face.
    for (const double apart : {2.0, 0.25, 0x1p-7, 0x1p-14})
        for (const double sine : {1.0, 0.5, 0x1p-4}) {
            const Vec3 axis = random().normalized(), across = axis.unitOrthogonal(), z = axis.cross(across),
                       crossing = 0.5 * axis;
            const Cylinder tube{crossing + apart * z, std::sqrt(1 - sine * sine) * axis + sine * across, 0.5};
            const Scene scene = about_tube({Vec3::Zero(), axis, 0.5}, 6,
                                           {tube, Sphere{5 * random().normalized(), 0.25},
                                            Cylinder{4 * z, at(rng) * axis + across, 0.125}});
            CAPTURE(apart);
            CAPTURE(sine);
            const Cell cell = checked(scene);
            std::size_t faces = 0;
            for (const CellFace& face : cell.faces) {
                if (face.site != Site::object(0)) continue;
                ++faces;
                // Steep ones take strips, as many as there are powers of two.
                if (apart >= 1) CHECK(face.patches.size() == 1);
                if (apart < 1e-3 && sine > 0.1) CHECK(face.patches.size() > 4);
                CHECK(face.patches.size() < 64);
                for (const TrimmedPatch& patch : face.patches) {
                    const RationalPatch& surface = patch.surface;
                    CHECK(surface.degree_u == 1);
                    CHECK(surface.degree_v == 1);
                    for (const Eigen::Vector4d& corner : surface.points) CHECK(corner.head<3>().norm() < 500);
                    // Beyond the trims, too.
                    for (int k = 0; k < 9; ++k) {
                        const double s = 0.5 * (k / 3), t = 0.5 * (k % 3);
                        const Vec3 p =
                            surface.evaluate(std::lerp(surface.domain_u[0], surface.domain_u[1], s),
                                             std::lerp(surface.domain_v[0], surface.domain_v[1], t));
                        CHECK(residual(scene, face.site, p) <= 1e-11 * (1 + p.squaredNorm()));
                    }
                }
            }
            CHECK(faces > 0);
        }
}

TEST_CASE("cells: among tubes of one radius that cross") {
    const Vec3 crossing(0, 2, -2);
    const Cylinder along_x{crossing, {1, 0, 0}, 0.25}, oblique{crossing, {0, 1, 1}, 0.25},
        third{crossing, {1, 1, 1}, 0.25};
    const auto has_node = [](const Cell& cell, std::size_t tubes) {
        const auto is_node = [&](const CellVertex& v) { return v.sites.size() == tubes; };
        CHECK(std::ranges::any_of(cell.vertices, is_node));
        // What is left of the one beside nodes may be some times the tolerance.
        for (const CellEdge& edge : cell.edges) CHECK(edge.error <= 16 * cell.scene.fit_tolerance());
        CHECK(cell.report.decisions.assumed == 0);
    };
    std::mt19937_64 rng(test_seed());
    // Once the line across the axes runs through the base's centre, or along a normal of its axis.
    Scene ball = centred(0.5, 4, {along_x, oblique});
    Cell cell = cell_of(ball);
    check_cell(cell);
    check_faces_by_rays(cell, rng, 3);
    has_node(cell, 2);
    std::get<Sphere>(ball.base).center.x() = 0.1;
    ball.objects.push_back(third);
    cell = cell_of(ball);
    check_cell(cell);
    check_faces_by_rays(cell, rng, 3);
    has_node(cell, 3);
    for (const Cylinder& tube :
         {Cylinder{Vec3::Zero(), {1, 0, 0}, 0.5}, Cylinder{Vec3::Zero(), {1, 2, 2}, 0.5},
          Cylinder{Vec3::Zero(), {-2, 1, 3}, 0.5}, Cylinder{{0.1, 0.2, 0.3}, {1, 3, 1}, 0.25}})
        has_node(checked(about_tube(tube, 4, {along_x, oblique})), 2);
    // Over a plane, where one coordinate of the node is 0.
    Scene plane;
    plane.base = Plane{};
    plane.objects = {Cylinder{{0, -2, 3}, {4, -3, 0}, 0.5}, Cylinder{{0, -3, 3}, {0, 1, 0}, 0.5}};
    plane.box = {Vec3::Constant(-8), Vec3::Constant(8)};
    has_node(voronoi_cell(plane), 2);
    // Lengths of directions are irrational, and so are the planes between the axes.
    std::uniform_real_distribution<double> number(-1, 1);
    plane.box = {Vec3::Constant(-2.5), Vec3::Constant(2.5)};
    for (int round = 0; round < 20; ++round) {
        const Vec3 place(number(rng), number(rng), 2);
        const Vec3 along(number(rng), 1, 0.25 * number(rng)), across(1, number(rng), 0.25 * number(rng));
        plane.objects = {Cylinder{place, along, 0.5}, Cylinder{place, across, 0.5}};
        has_node(voronoi_cell(plane), 2);
    }
    // Two pairs that cross, tilted.
    has_node(checked(about_tube({Vec3::Zero(), {1, 1, 0}, 0.5}, 3,
                                {Cylinder{{2, 0, 3}, {0, 0, -1}, 0.25}, Cylinder{{2, 1, 2}, {-1, 1, 1}, 0.25},
                                 Cylinder{{3, 0, 1}, {-1, 0, -1}, 0.25}})),
             2);
    // One of them along a tilted base.
    has_node(checked(about_tube(
                 {Vec3::Zero(), {1, 1, 0}, 0.25}, 7,
                 {Cylinder{{3, -3, 1.5}, {-2, -2, 0}, 0.25}, Cylinder{{1, 1, 1.5}, {-2, 1, 0}, 0.25}})),
             2);
    // Lines along the axis and across it.
    has_node(checked(about_tube({Vec3::Zero(), {1, 0, 0}, 0.5}, 3,
                                {Cylinder{{-2, 1, -1}, {-1, 0, 0}, 0}, Cylinder{{0, 1, -1}, {0, 1, 0}, 0}})),
             2);
}

// On both sides of the crossing the cell has parts, which end as near to it as to planes of the box's sides.
TEST_CASE("cylinder cell: tubes of its radius whose axes cross its own leave it parts, however it leans") {
    const Vec3 crossing(1, 2, -1);
    for (const Vec3& along : {Vec3(0, 0, 1), Vec3(-1, 1, 2), Vec3(1, -1, 0), Vec3(2, 3, -1)})
        for (const Vec3& across : {Vec3(0, -2, 1), Vec3(-1, 0, 0), Vec3(2, -2, -1)}) {
            const Cylinder base{crossing - 0.5 * along, along, 0.25};
            const auto cell_among = [&](const Vec3& point) {
                return voronoi_cell(about_tube(base, 4, {Cylinder{point, across, 0.25}}));
            };
            const Cell cell = cell_among(crossing + 3 * across);
            CHECK(cell.is_complete);
            CHECK(cell.report.decisions.assumed == 0);
            const auto is_beside = [&](const CellPart& part, int end) {
                return (part.ends[end] - crossing).norm() < 1e-6;
            };
            int parts = 0;
            for (std::size_t k = 1; k < cell.parts.size(); ++k)
                parts += is_beside(cell.parts[k - 1], 1) && is_beside(cell.parts[k], 0) ? 1 : 0;
            CHECK(parts == 1);
            int planes = 0;
            for (const CellFace& face : cell.faces) {
                if (!face.site.is_object()) continue;
                CHECK(face.bisector == "plane");
                for (const TrimmedPatch& patch : face.patches) CHECK(patch.surface.degree_u == 1);
                ++planes;
            }
            CHECK(planes >= 4);
            // Where the axes pass each other it is whole.
            const Cell beside = cell_among(crossing + along.cross(across).normalized());
            CHECK_FALSE(beside.faces.empty());
            CHECK(beside.parts.empty());
        }
}

// One of them is two walls to the base, which it crosses elsewhere.
TEST_CASE("cylinder cell: nodes of tubes that cross, one of which crosses the base, too, are decided") {
    const Cylinder base{Vec3::Zero(), {0, 1, 0}, 0.5}, first{Vec3::Zero(), {1, 0, 0}, 0.5};
    int nodes = 0;
    for (const Vec3& axis : {Vec3(0, 1, 2), Vec3(0, -2, 1), Vec3(1, 1, 2)}) {
        const Cell cell = voronoi_cell(about_tube(base, 4, {first, Cylinder{{2, 0, 0}, axis, 0.5}}));
        CHECK(cell.report.decisions.assumed == 0);
        nodes += static_cast<int>(std::ranges::count_if(cell.vertices, [](const CellVertex& v) {
            return std::ranges::equal(v.sites, std::array{Site::object(0), Site::object(1)});
        }));
    }
    CHECK(nodes > 0);
}

TEST_CASE("cells: among tubes of one radius that cross but for rounding") {
    // Edges turn from one plane between the axes to the other within 1e-8; doubles lose them within 1e-6.
    const Eigen::Matrix3d turn = Eigen::Quaterniond(0.8, 0.3, -0.4, 0.33).normalized().toRotationMatrix();
    const std::vector<Object> tubes{Cylinder{turn * Vec3(-2, 1, -1), turn * Vec3(-1, 0, 0), 0.25},
                                    Cylinder{turn * Vec3(0, 1, -1), turn * Vec3(0, 1, 0), 0.25}};
    const Cell of_tube = checked(about_tube({Vec3::Zero(), turn * Vec3(1, 0, 0), 0.5}, 4, tubes));
    const Cell of_ball = cell_of(centred(0.5, 4, tubes));
    check_cell(of_ball);
    for (const Cell* cell : {&of_tube, &of_ball})
        for (const CellEdge& edge : cell->edges) CHECK(edge.error <= 1e-3);
}

TEST_CASE("cells: what touches an edge of two others is a vertex of it") {
    const Cylinder left{{-1, 0, 1}, {0, 1, 0}, 0}, right{{1, 0, 1}, {0, 1, 0}, 0};
    const auto scene = [&](const Object& base, double z) {
        Scene s = std::holds_alternative<Sphere>(base)
                      ? centred(0, 4, {left, right})
                      : about_tube(std::get<Cylinder>(base), 4, {left, right});
        s.base = base;
        s.objects.push_back(Sphere{{0, 0.25, z}, 0});
        return s;
    };
    std::mt19937_64 rng(test_seed());
    const auto checked_cell = [&](const Scene& s) {
        const Cell cell = cell_of(s);
        check_cell(cell);
        if (std::holds_alternative<Sphere>(s.base))
            check_faces_by_rays(cell, rng, 3);
        else
            check_cylinder_faces(cell, rng, 12);
        return cell;
    };
    const Site third = Site::object(2);
    for (const Object& base :
         {Object(Cylinder{Vec3::Zero(), {0, 1, 0}, 0}), Object(Sphere{{0, 0.25, 0}, 0})}) {
        CAPTURE(base.index());
        for (const double lift : {-1e-3, 0.0, 1e-3}) {
            CAPTURE(lift);
            const Cell cell = checked_cell(scene(base, 2 + lift));
            CHECK(std::ranges::count(cell.faces, third, &CellFace::site) == (lift < 0));
            const auto meets = std::ranges::count_if(cell.vertices, [&](const CellVertex& v) {
                return std::ranges::find(v.sites, third) != v.sites.end();
            });
            CHECK((lift < 0 ? meets >= 2 : meets == (lift == 0)));
            CHECK(cell.report.decisions.assumed == 0);
            if (lift != 0) continue;
            const auto vertex = std::ranges::find_if(cell.vertices, [&](const CellVertex& v) {
                return std::ranges::find(v.sites, third) != v.sites.end();
            });
            CHECK(vertex->sites.size() == 3);
            CHECK((vertex->point - Vec3(0, 0.25, 1)).norm() <= vertex->error + 1e-15);
            CHECK(vertex->error <= 1e-7);
        }
    }
}

TEST_CASE("cylinder cell: axes that are all but parallel") {
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 0.5};
    for (const double slope : {1e-3, 1e-6, 1e-9}) {
        CAPTURE(slope);
        // Axes that pass nearer to each other than |delta|, far beyond the ends.
        checked(about_tube(tube, 4, {Cylinder{{1.5, 0, 0}, {slope, 0.01 * slope, -1}, 0.7}}));
        checked(about_tube(
            tube, 4,
            {Cylinder{{1.5, 0, 0}, {slope, 0, 1}, 0.5}, Cylinder{{0, -2, 0}, {slope, -slope, 1}, 0.3}}));
    }
}

TEST_CASE("cylinder cell: vertices are known to rounding at every scale") {
    for (const double scale : {1e-6, 1.0, 1e6}) {
        CAPTURE(scale);
        const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitZ(), 0.5 * scale}, 4 * scale,
                                             {Cylinder{scale * Vec3(1.5, 0, 0), {1, 2, 3}, 0.3 * scale},
                                              Cylinder{scale * Vec3(-1, 1, 0.5), {1, 1, 0.5}, 0.25 * scale},
                                              Sphere{scale * Vec3(0.5, -2, 1), scale}}));
        for (const CellVertex& v : cell.vertices) CHECK(v.error <= 4e-12 * scale);
    }
}

TEST_CASE("cylinder cell: arcs that turn beside a seam, and vertices on one") {
    Scene turning;
    turning.base = Cylinder{{-0.05, 0.63, 0.92}, {-0.4591667997360513, 0.5912304283554172, 0.663}, 0.3};
    turning.objects = {Cylinder{{0.27, 0.76, -0.12}, {-0.8, 0.23518019618049804, 0.4835843489437807}, 0},
                       Sphere{{0.6, 0.8, 0.4}, 0.1}, Plane{{1, -0.2, 2.3}, {0.53, -0.4, 0.7}}};
    turning.box = {{-3, -2.5, -2.3}, {3.1, 3.9, 4}};
    checked(turning);
    Scene meeting;
    meeting.base = Cylinder{{-0.7, 0.1, -0.48}, {0, 1, 0}, 0.48};
    meeting.objects = {Cylinder{{-0.8, 0.6, -1.3}, {0.84, -0.3, -0.464}, 0.1}};
    meeting.box = {{-3.662, -3, -3.7}, {2.4, 3.4, 2.6}};
    checked(meeting);
}

// The default tolerance is 7e-7 here, which is not far below the cells' size.
TEST_CASE("cells: curves are fine as the cell, however large its box") {
    constexpr double size = 1e-6;
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0};
    scene.box = {{-2, -2, -2}, {2, 2, 2}};
    for (const auto& [place, axis] :
         std::initializer_list<std::pair<Vec3, Vec3>>{{{1, 0.2, 0.1}, {0.1, 1, 0.3}},
                                                      {{-1, 0.3, -0.2}, {0.2, -0.4, 1}},
                                                      {{0.1, 1, 0.3}, {1, 0.1, 0.7}},
                                                      {{0.2, -1, -0.1}, {0.5, 0.2, 1}},
                                                      {{-0.2, 0.1, 1}, {1, 1, 0.2}},
                                                      {{0.3, -0.1, -1}, {1, -0.8, 0.1}}})
        scene.objects.push_back(Cylinder{size * place, axis, 0});
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.edges.size() == 12);
    for (const CellEdge& e : cell.edges) CHECK(e.error < 1e-3 * size);
}

TEST_CASE("cylinder cell: random scenes") {
    std::mt19937_64 rng(test_seed());
    SceneMaker make{rng};
    for (int i = 0; i < 6; ++i) {
        CAPTURE(i);
        const Cylinder tube{make.vector(2), make.vector(1), make.number(0.3, 1)};
        std::vector<Object> objects;
        const Vec3 axis = tube.axis.normalized();
        for (int k = 0; k < 5; ++k) {
            Vec3 side = make.vector(1);
            side = (side - side.dot(axis) * axis).normalized();
            const double rho = make.number(0.1, 1.2);
            const Vec3 at =
                tube.point + axis * make.number(-3, 3) + side * (tube.radius + rho + make.number(0.2, 2));
            if (k % 2 == 0)
                objects.push_back(Cylinder{at, side.cross(make.vector(1)), rho});
            else
                objects.push_back(Sphere{at, rho});
        }
        checked(about_tube(tube, 6, objects), i);
    }
}

}  // namespace vcell::crossing_tubes_test
