/// Cells of base planes in hollow spheres and cylinders, whose region has a curved rim, against distances
/// alone.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/point_query.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"
#include "vessel_oracle.hpp"

namespace vcell {
namespace {

using vessel_oracle::away;
using vessel_oracle::pi;

const Box wide{{-2, -2, -2}, {2, 2, 2}};

// A plane's normal with the axes across it.
struct Axes {
    Vec3 up, x, y;

    explicit Axes(const Plane& base) : up(base.normal.normalized()), x(up.unitOrthogonal()), y(up.cross(x)) {}
};

// How high the cell is over a point of the base; none where there is no cell.
std::optional<double> height_over(const Scene& scene, const Vec3& foot) {
    const Vec3 up = Axes(std::get<Plane>(scene.base)).up;
    const auto is_in = [&](double t) {
        const Vec3 p = foot + t * up;
        return vessel_oracle::inside_box(scene.box, p) >= 0 &&
               std::ranges::all_of(scene.objects, [&](const Object& o) { return away(o, p) >= t; });
    };
    if (!is_in(0)) return std::nullopt;
    double low = 0, high = scene.box.diagonal();
    for (int i = 0; i < 50; ++i) (is_in(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return low;
}

// By a rule of points on a square grid. The boundary of what it is taken over leaves an error of about the
// step, times how much of it there is, over the square root of how many steps that takes.
struct Sampled {
    double volume = 0, base_area = 0, highest = 0;

    Sampled(const Scene& scene, int rows) {
        const auto& base = std::get<Plane>(scene.base);
        const Axes axes(base);
        const double size = 0.5 * scene.box.diagonal(), step = 2 * size / rows;
        const Vec3 middle = 0.5 * (scene.box.min + scene.box.max),
                   origin = middle - axes.up.dot(middle - base.point) * axes.up;
        for (int i = 0; i < rows; ++i)
            for (int k = 0; k < rows; ++k) {
                const Vec3 foot =
                    origin + (-size + (i + 0.5) * step) * axes.x + (-size + (k + 0.5) * step) * axes.y;
                const auto height = height_over(scene, foot);
                if (!height) continue;
                volume += step * step * *height;
                base_area += step * step;
                highest = std::max(highest, *height);
            }
    }
};

void check_against_samples(const Scene& scene, const Cell& cell, int rows = 200) {
    const Sampled sampled(scene, rows);
    CHECK(cell.measures.volume == doctest::Approx(sampled.volume).epsilon(0.01));
    CHECK(cell.measures.base_area == doctest::Approx(sampled.base_area).epsilon(0.01));
    CHECK(cell.measures.max_clearance >= sampled.highest - cell.measures.max_clearance_error - 1e-9);
    CHECK(cell.measures.max_clearance == doctest::Approx(sampled.highest).epsilon(0.02));
}

// Every vertex is as far from all its sites as from the base, or, where two are, from the rim on the base.
void check_vertices_on(const Cell& cell) {
    const auto& base = std::get<Plane>(cell.scene.base);
    for (const CellVertex& v : cell.vertices) {
        const double slop = 4 * v.error + 1e-13 * cell.scene.box.diagonal();
        CHECK(std::abs(base.normal.normalized().dot(v.point - base.point) - v.radius) <= slop);
        for (const Site& s : v.sites)
            if (s.is_object()) CHECK(std::abs(away(cell.scene.objects[s.index], v.point) - v.radius) <= slop);
        for (const Object& o : cell.scene.objects) CHECK(away(o, v.point) >= v.radius - slop);
    }
}

TEST_CASE("planes in vessels: alone in a hollow sphere a plane has all below a paraboloid") {
    for (const double height : {0.0, 0.5, -0.5}) {
        CAPTURE(height);
        Scene scene;
        scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
        scene.objects = {HollowSphere{{0.25, 0, height}, 1.25}};
        scene.box = wide;
        const Cell cell = voronoi_cell(scene);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.faces[0].bisector == "paraboloid");
        REQUIRE(cell.edges.size() == 1);
        CHECK(cell.edges[0].vertices.empty());
        CHECK(cell.edges[0].kind == CurveKind::Circle);
        CHECK(cell.edges[0].sites == std::array{Site::object(0), Site::object(0)});
        const Measures& m = cell.measures;
        const double square = 1.25 * 1.25 - height * height, width = 2 * (1.25 - height);
        const auto check = [](double value, double error, double truth) {
            CHECK(std::abs(value - truth) <= error + 1e-15);
            CHECK(error < 1e-12);
        };
        check(m.base_area, m.base_area_error, pi * square);
        check(m.volume, m.volume_error, pi * square * square / (2 * width));
        check(m.min_clearance, m.min_clearance_error, 0);
        check(m.max_clearance, m.max_clearance_error, 0.5 * (1.25 + height));
        check(cell.edges[0].length, cell.edges[0].length_error, 2 * pi * std::sqrt(square));
        CHECK(!m.touches_box);
        CHECK(cell.neighbors == std::vector<std::uint32_t>{0});
    }
}

void check_close(double value, double error, double truth) {
    CHECK(std::abs(value - truth) <= error + 1e-14);
    CHECK(error < 1e-10);
}

// Below the tip at height R lies the cone over the trace of the wall on the base.
TEST_CASE(
    "planes in vessels: alone in a hollow cylinder a plane has all below a cone or a parabolic cylinder") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = wide;
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(0, 0, -2), Vec3(1, 2, 3), Vec3(-0.5, 0, 1)}) {
        CAPTURE(axis.transpose());
        constexpr double radius = 1.125;
        scene.objects = {HollowCylinder{{0.125, -0.25, 0.5}, axis, radius}};
        const Cell cell = voronoi_cell(scene);
        const bool is_upright = axis.head<2>().isZero(0);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.faces[0].bisector == (is_upright ? "circular cone" : "elliptic cone"));
        CHECK(cell.faces[0].patches.size() == 3);
        REQUIRE(cell.edges.size() == 1);
        CHECK(cell.edges[0].vertices.empty());
        CHECK(cell.edges[0].kind == (is_upright ? CurveKind::Circle : CurveKind::Ellipse));
        CHECK(cell.edges[0].error < 1e-11);
        const Measures& m = cell.measures;
        const double area = pi * radius * radius / std::abs(axis.normalized().z());
        check_close(m.base_area, m.base_area_error, area);
        check_close(m.volume, m.volume_error, area * radius / 3);
        check_close(m.min_clearance, m.min_clearance_error, 0);
        check_close(m.max_clearance, m.max_clearance_error, radius);
        if (is_upright) {
            check_close(m.area, m.area_error, std::sqrt(2) * area);
            check_close(cell.edges[0].length, cell.edges[0].length_error, 2 * pi * radius);
        }
        CHECK(!m.touches_box);
    }
    for (const double height : {0.25, 0.0, -0.5}) {
        CAPTURE(height);
        scene.objects = {HollowCylinder{{0, 0.25, height}, {1, 0, 0}, 1.25}};
        const Cell cell = voronoi_cell(scene);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.faces[0].bisector == "parabolic cylinder");
        CHECK(cell.edges.size() == 4);
        const Measures& m = cell.measures;
        const double square = 1.25 * 1.25 - height * height, width = std::sqrt(square);
        check_close(m.base_area, m.base_area_error, 8 * width);
        check_close(m.volume, m.volume_error, 4 * (4.0 / 3) * square * width / (2 * (1.25 - height)));
        check_close(m.max_clearance, m.max_clearance_error, 0.5 * (1.25 + height));
        CHECK(m.touches_box);
    }
}

// Over an upright cone's trace, a disk of radius rho, lies a cone up to its tip on the axis: at S h / (1 - S)
// over the base from an apex h below, and S h / (1 + S) under an apex above it. Half a leaning one's trace
// between the places where the wall's lines in its plane of symmetry meet the base is an axis of the ellipse.
TEST_CASE("planes in vessels: alone in a hollow cone a plane has all below a cone") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = wide;
    // Half its angle has a sine of 3 / 5, a tangent of 3 / 4.
    for (const bool is_roof : {false, true}) {
        CAPTURE(is_roof);
        const double h = is_roof ? 1.5 : 1, radius = 0.75 * h;
        scene.objects = {HollowCone{{0.125, -0.25, is_roof ? h : -h}, {0, 0, is_roof ? -2.0 : 1.0}, 3, 5}};
        const Cell cell = voronoi_cell(scene);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.faces[0].bisector == "circular cone");
        CHECK(cell.faces[0].patches.size() == 3);
        REQUIRE(cell.edges.size() == 1);
        CHECK(cell.edges[0].kind == CurveKind::Circle);
        CHECK(cell.edges[0].error < 1e-11);
        const Measures& m = cell.measures;
        const double tip = 0.6 * h / (is_roof ? 1.6 : 0.4), area = pi * radius * radius;
        check_close(m.base_area, m.base_area_error, area);
        check_close(m.volume, m.volume_error, area * tip / 3);
        check_close(m.area, m.area_error, pi * radius * std::hypot(radius, tip));
        check_close(m.min_clearance, m.min_clearance_error, 0);
        check_close(m.max_clearance, m.max_clearance_error, tip);
        CHECK(!m.touches_box);
    }
    // The axis leans by an angle of tangent 1 / 4: lines of the wall by tangents (3/4 +- 1/4) / (1 -+ 3/16).
    const double h = 1, near = (0.5 / (1 + 3.0 / 16)) * h, far = (1 / (1 - 3.0 / 16)) * h;
    scene.objects = {HollowCone{{0, 0, -h}, {0.25, 0, 1}, 3, 5}};
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 1);
    CHECK(cell.faces[0].bisector == "elliptic cone");
    CHECK(cell.faces[0].patches.size() == 3);
    REQUIRE(cell.edges.size() == 1);
    CHECK(cell.edges[0].kind == CurveKind::Ellipse);
    // The section has the area of a disk whose radius is the mean of both ends' distances from the axis,
    // looked at along that.
    const double cosine = 1 / std::hypot(1, 0.25), half = 0.5 * (near + far);
    const double low = 0.6 * std::hypot(near, h), high = 0.6 * std::hypot(far, h);
    const double area = pi * half * std::sqrt(low * high);
    check_close(cell.measures.base_area, cell.measures.base_area_error, area);
    const double tip = 0.6 * h / (cosine - 0.6);
    check_close(cell.measures.volume, cell.measures.volume_error, area * tip / 3);
    check_close(cell.measures.max_clearance, cell.measures.max_clearance_error, tip);
}

// A cone of which a line of the wall is level opens over a parabola, and its bisector is a parabolic
// cylinder; one that lies down, over a hyperbola's branch.
TEST_CASE("planes in vessels: cones that lie down") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = wide;
    const auto check = [&](const HollowCone& cone, const std::vector<CurveKind>& rim,
                           const std::string& bisector) {
        CAPTURE(cone.apex.transpose());
        scene.objects = {cone};
        const Cell cell = voronoi_cell(scene);
        std::vector<CurveKind> kinds;
        for (const CellEdge& e : cell.edges)
            if (e.sites == std::array{Site::object(0), Site::object(0)}) kinds.push_back(e.kind);
        CHECK(kinds == rim);
        CHECK(cell.faces[0].bisector == bisector);
        check_against_samples(scene, cell, 300);
        check_vertices_on(cell);
    };
    // A level line lies below the base, then above it.
    check({{-1, 0, -0.5}, {4, 0, 3}, 3, 5}, {CurveKind::Parabola}, "parabolic cylinder");
    check({{-1, 0.25, 0.75}, {4, 0, -3}, 3, 5}, {CurveKind::Parabola}, "elliptic cone");
    for (const double height : {0.5, -0.25})
        check({{-1, 0.125, height}, {1, 0.25, 0.125}, 4, 5}, {CurveKind::Hyperbola}, "elliptic cone");
    // The apex is on the base, beyond the box.
    check({{-3, 0, 0}, {1, 0.25, 0}, 1, 2}, {CurveKind::Line, CurveKind::Line}, "elliptic cone");
}

TEST_CASE("planes in vessels: walls that cross, the box and other objects bound what is over the base") {
    Scene scene;
    scene.base = Plane{{0, 0, 0.125}, {0, 0, 1}};
    scene.box = wide;
    SUBCASE("two walls") {
        scene.objects = {HollowSphere{{0.5, 0, 0}, 1.25}, HollowSphere{{-0.5, 0.25, 0.5}, 1.5},
                         Sphere{{0, 0, 0.75}, 0.25}};
    }
    SUBCASE("a wall and the box") {
        scene.box.max.x() = 0.75;
        scene.objects = {HollowSphere{{0.25, 0, 0.25}, 1.5}, Sphere{{0.25, 0.25, 1}, 0.25},
                         Plane{{0, 0, 1.25}, {0, 0.25, 1}}};
    }
    SUBCASE("a wall and tubes") {
        scene.objects = {HollowSphere{{0.25, 0, 0.25}, 1.5}, Cylinder{{0, 0, 0.75}, {1, 0.5, 0.125}, 0.125},
                         Cylinder{{0.25, 0, 0.75}, {1, -0.5, 0}, 0.125}};
    }
    SUBCASE("all of the region is within the wall") {
        scene.box = {{-0.75, -0.5, -1}, {0.5, 0.75, 1}};
        scene.objects = {HollowSphere{{0, 0, 0.25}, 1.25}, Sphere{{0.25, 0.25, 1}, 0.25}};
    }
    SUBCASE("a silo and the box") {
        scene.box.max.x() = 0.75;
        scene.objects = {HollowCylinder{{0.25, 0, 0}, {0, 0, 1}, 1.25}, Sphere{{0.25, 0.25, 1}, 0.25},
                         Plane{{0, 0, 1.25}, {0, 0.25, 1}}, Sphere{{-0.5, 0.25, 0.5}, 0.25}};
    }
    SUBCASE("an oblique silo, a hollow sphere and tubes") {
        scene.objects = {HollowCylinder{{0, 0, 0.25}, {0.25, -0.5, 1}, 1}, HollowSphere{{0.25, 0, 0.25}, 1.5},
                         Cylinder{{0, 0, 0.75}, {1, 0.5, 0.125}, 0.125}};
    }
    SUBCASE("silos that cross") {
        scene.objects = {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1},
                         HollowCylinder{{0.5, 0.25, 0}, {0, 0, 1}, 1},
                         HollowCylinder{{0.25, 0, 0.25}, {0.5, 0.5, 1}, 1}, Sphere{{0.25, 0.25, 1}, 0.25}};
    }
    SUBCASE("a pipe around a silo") {
        scene.objects = {HollowCylinder{{0, 0, 0.25}, {1, 0.25, 0}, 0.75},
                         HollowCylinder{{0.125, 0.25, 0}, {0, 0, 1}, 1}, Sphere{{0.25, 0.25, 0.75}, 0.25}};
    }
    SUBCASE("a hopper with balls, and a tube across it") {
        scene.objects = {HollowCone{{0.125, 0, -1.5}, {0, 0, 1}, 3, 5}, Sphere{{0.25, 0.25, 1}, 0.25},
                         Sphere{{-0.5, 0.25, 0.5}, 0.25}, Cylinder{{0, -0.5, 0.75}, {1, 0.25, 0.125}, 0.125}};
    }
    SUBCASE("a hopper in a leaning silo in a ball") {
        scene.objects = {HollowCone{{0.125, 0, -1.5}, {0.25, 0, 1}, 3, 5},
                         HollowCylinder{{0, 0, 0.25}, {0.25, -0.5, 1}, 1}, HollowSphere{{0.25, 0, 0.25}, 1.5},
                         Sphere{{0.25, 0.25, 0.75}, 0.25}};
    }
    SUBCASE("two roofs and the box") {
        scene.box.max.x() = 0.5;
        scene.objects = {HollowCone{{0.25, 0, 1.5}, {0.25, 0.125, -1}, 1, 1.25},
                         HollowCone{{-0.25, 0.5, 1}, {0, 0, -1}, 3, 4}, Sphere{{0.25, 0.25, 0.5}, 0.125}};
    }
    SUBCASE("a leaning base in a hopper") {
        scene.base = Plane{{0, 0, -0.125}, {0.125, 0.25, 1}};
        scene.objects = {HollowCone{{0, 0, -1.5}, {0, 0, 1}, 3, 5}, Sphere{{0.25, 0.25, 1}, 0.25},
                         Cylinder{{-0.25, 0.5, 0.5}, {1, 0.25, 0}, 0.125}};
    }
    SUBCASE("a ring around a ball") {
        scene.objects = {HollowCylinder{{0.125, 0, 0}, {0, 0.125, 1}, 1}, Sphere{{0.125, 0, 0.75}, 0.5}};
    }
    SUBCASE("a leaning base in a silo") {
        scene.base = Plane{{0, 0, -0.125}, {0.125, 0.25, 1}};
        scene.box = {{-0.75, -1.125, -1}, {1.125, 0.875, 1.5}};
        scene.objects = {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1}, Sphere{{0.25, 0.25, 1}, 0.25},
                         Cylinder{{-0.25, 0.5, 0.5}, {1, 0.25, 0}, 0.125}};
    }
    SUBCASE("a leaning base") {
        scene.base = Plane{{0, 0, -0.125}, {0.125, 0.25, 1}};
        scene.objects = {HollowSphere{{0.25, 0, 0.25}, 1.5}, Sphere{{0.25, 0.25, 1}, 0.25},
                         Sphere{{-0.25, 0.5, 0.5}, 0.25}, HollowSphere{{-0.5, 0.25, 0.5}, 1.625}};
    }
    const Cell cell = voronoi_cell(scene);
    check_against_samples(scene, cell);
    check_vertices_on(cell);
}

TEST_CASE("planes in vessels: random balls over random planes") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < long_rounds(6); ++round) {
        CAPTURE(round);
        Scene scene;
        scene.base =
            Plane{0.2 * Vec3(unit(rng), unit(rng), unit(rng)), Vec3(unit(rng), unit(rng), unit(rng))};
        scene.box = wide;
        scene.objects = {HollowSphere{0.3 * Vec3(unit(rng), unit(rng), unit(rng)), 1.5},
                         HollowSphere{0.5 * Vec3(unit(rng), unit(rng), unit(rng)), 1.75}};
        if (round % 3 == 0)
            scene.objects[1] = HollowCylinder{
                0.3 * Vec3(unit(rng), unit(rng), unit(rng)), {unit(rng), unit(rng), unit(rng)}, 1};
        if (round % 3 == 1) {
            const Vec3 axis = Vec3(unit(rng), unit(rng), unit(rng)).normalized();
            scene.objects[1] = HollowCone{-axis + 0.3 * Vec3(unit(rng), unit(rng), unit(rng)), axis, 3, 4};
        }
        while (scene.objects.size() < 12) {
            const Sphere ball{1.3 * Vec3(unit(rng), unit(rng), unit(rng)), 0.1 + 0.1 * std::abs(unit(rng))};
            if (std::abs(away(scene.base, ball.center)) > 1.05 * ball.radius) scene.objects.push_back(ball);
        }
        const Cell cell = voronoi_cell(scene);
        check_against_samples(scene, cell);
        check_vertices_on(cell);
        PointQuery query(scene);
        const Axes axes(std::get<Plane>(scene.base));
        for (int i = 0; i < 200; ++i) {
            const Vec3 foot =
                std::get<Plane>(scene.base).point + 2 * unit(rng) * axes.x + 2 * unit(rng) * axes.y;
            const auto height = height_over(scene, foot);
            if (height && *height < 1e-6) continue;
            const double t = height ? 0.5 * *height : 0.1;
            const auto answer = query(foot + t * axes.up);
            CHECK(answer.has_value() == height.has_value());
            if (!answer || !height) continue;
            CHECK(answer->inside);
            CHECK(answer->clearance == doctest::Approx(*height).epsilon(1e-9).scale(1));
        }
    }
}

TEST_CASE(
    "planes in vessels: of equal hollow cylinders one bounds the cell, wider ones are left out by name") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = wide;
    scene.objects = {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1.5}, HollowCylinder{{0.25, 0, 0}, {0, 0, 1}, 1},
                     HollowCylinder{{0.25, 0, 3}, {0, 0, -2}, 1}};
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 1);
    CHECK(cell.faces[0].site == Site::object(1));
    CHECK(cell.faces[0].extra_sites == std::vector{Site::object(2)});
    REQUIRE(cell.report.warnings.size() == 2);
    CHECK(cell.report.warnings[0].find("beyond the wall of") != std::string::npos);
}

// A wall that touches sides of the box, as a silo does the box around it, has vertices there.
TEST_CASE("planes in vessels: walls that touch sides of the box") {
    for (const double radius : {1.0, 0.75}) {
        CAPTURE(radius);
        Scene scene;
        scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
        scene.box = {{0.25 - radius, -radius, -1}, {0.25 + radius, radius, 2}};
        scene.objects = {HollowCylinder{{0.25, 0, 0}, {0, 0, 1}, radius}, Sphere{{0.25, 0.25, 0.5}, 0.25}};
        const Cell cell = voronoi_cell(scene);
        CHECK(cell.vertices.size() == 4);
        CHECK(cell.report.decisions.assumed == 0);
        CHECK(std::abs(cell.measures.base_area - pi * radius * radius) <= cell.measures.base_area_error);
        check_against_samples(scene, cell);
        check_vertices_on(cell);
    }
}

TEST_CASE("planes in vessels: none is left of a plane beyond the walls") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = wide;
    const auto is_empty = [&](std::vector<Object> objects) {
        scene.objects = std::move(objects);
        try {
            voronoi_cell(scene);
        } catch (const InputError& e) {
            return e.kind == InputError::Kind::EmptyBox;
        }
        return false;
    };
    CHECK(is_empty({HollowSphere{{0, 0, 1.25}, 1}}));
    CHECK(is_empty({HollowSphere{{0, 0, 1}, 1}}));  // touches it
    CHECK(is_empty({HollowSphere{{0, 0, -1.25}, 1}}));
    CHECK(is_empty({HollowSphere{{4, 0, 0}, 1}}));
    CHECK(is_empty({HollowSphere{{1, 0, 0}, 0.75}, HollowSphere{{-1, 0, 0}, 0.75}}));
    CHECK(is_empty({HollowSphere{{1, 0, 0}, 1}, HollowSphere{{-1, 0, 0}, 1}}));
    CHECK(!is_empty({HollowSphere{{1, 0, 0}, 1.0625}, HollowSphere{{-1, 0, 0}, 1}}));
    CHECK(is_empty({HollowCylinder{{0, 0, 1.25}, {1, 0, 0}, 1}}));
    CHECK(is_empty({HollowCylinder{{0, 0, 1}, {1, 0, 0}, 1}}));
    CHECK(is_empty({HollowCylinder{{3, 0, 0}, {0, 0, 1}, 1}}));
    CHECK(is_empty({HollowCylinder{{1, 0, 0}, {0, 0, 1}, 0.9}, HollowCylinder{{-1, 0, 0}, {0, 0, 1}, 1}}));
    CHECK(is_empty({HollowCone{{0, 0, 0.5}, {0, 0, 1}, 3, 5}}));      // the other half would hold some
    CHECK(is_empty({HollowCone{{0, 0, 0}, {0, 0, 1}, 3, 5}}));        // the apex touches it
    CHECK(is_empty({HollowCone{{0, 0, 0.5}, {4, 0, 3}, 3, 5}}));      // a level line above it
    CHECK(is_empty({HollowCone{{-3, 0, -1}, {-1, 0, 0}, 4, 5}}));     // a branch beyond the box
    CHECK(!is_empty({HollowCone{{-3, 0, -0.5}, {1, 0, 0}, 4, 5}}));   // this one comes in
    CHECK(!is_empty({HollowCone{{0, 0, -0.125}, {0, 0, 1}, 3, 5}}));  // an ellipse amidst the region
}

// What is nearest to a plane, on both of its sides, by random points.
TEST_CASE("planes in vessels: whole diagrams have cells of planes") {
    DiagramScene scene;
    scene.objects = {Plane{{0, 0, -0.5}, {0.25, 0, 1}}, HollowSphere{{0, 0, 0}, 1.5},
                     Sphere{{0.25, 0, 0.5}, 0.375}, Sphere{{-0.5, 0.25, 0.25}, 0.25},
                     Plane{{0, 0, -1.625}, {0, 0, 1}}};
    SUBCASE("in a hollow sphere") {}
    SUBCASE("in a hollow sphere and a cone") {
        scene.objects.push_back(HollowCone{{0.125, 0, -1.25}, {0.125, 0.0625, 1}, 5, 8});
    }
    scene.box = {Vec3::Constant(-1.5), Vec3::Constant(1.5)};
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    CHECK(diagram.cells[1].state == DiagramCell::State::Wall);
    CHECK(diagram.cells[4].state == DiagramCell::State::Empty);
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1.5, 1.5);
    std::vector<int> hits(scene.objects.size(), 0);
    constexpr int samples = 100'000;
    for (int i = 0; i < samples; ++i) {
        const Vec3 p(unit(rng), unit(rng), unit(rng));
        const auto nearest =
            std::ranges::min_element(scene.objects, {}, [&](const Object& o) { return away(o, p); });
        ++hits[static_cast<std::size_t>(nearest - scene.objects.begin())];
    }
    for (const std::size_t i : {0u, 2u, 3u}) {
        CAPTURE(i);
        CHECK(diagram.cells[i].state == DiagramCell::State::Computed);
        const double part = static_cast<double>(hits[i]) / samples;
        CHECK(std::abs(diagram.cells[i].volume / 27 - part) <= 5 * std::sqrt(part / samples));
    }
    scene.objects.push_back(HollowCylinder{{0, 0, 0}, {0, 0.25, 1}, 2});
    CHECK(voronoi_diagram(scene).cells[0].state == DiagramCell::State::Computed);
    scene.objects.push_back(HollowCone{{0, 0, -4}, {0, 0, 1}, 1, 2});
    CHECK(voronoi_diagram(scene).cells[0].state == DiagramCell::State::Computed);
}

}  // namespace
}  // namespace vcell
