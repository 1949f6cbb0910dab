/// Balls in spheres and tubes: cells against closed forms and against distances as they are, whole diagrams
/// of them.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <random>
#include <set>

#include "../../core/errors.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"
#include "vessel_oracle.hpp"

namespace vcell::vessels_test {
namespace {

using namespace vessel_oracle;

// ---- Scenes ---------------------------------------------------------------------------------------------

Scene in_sphere(const Sphere& base, const HollowSphere& vessel) {
    Scene scene;
    scene.base = base;
    scene.objects = {vessel};
    const Vec3 half = Vec3::Constant(1.25 * vessel.radius);
    scene.box = {vessel.center - half, vessel.center + half};
    return scene;
}

// ---- Spheres --------------------------------------------------------------------------------------------

TEST_CASE("vessels: about a ball in the middle of a sphere the cell is a sphere half-way") {
    const Scene scene = in_sphere({{1, 2, 3}, 0.5}, {{1, 2, 3}, 3.5});
    for (const bool patches : {false, true}) {
        CAPTURE(patches);
        CellOptions options;
        options.patches = patches;
        const Cell cell = voronoi_cell(scene, options);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.vertices.empty());
        CHECK(cell.edges.empty());
        CHECK(cell.neighbors == std::vector<std::uint32_t>{0});
        const Measures& m = cell.measures;
        const double t = 2;
        CHECK(std::abs(m.volume - 4 * pi / 3 * t * t * t) <= m.volume_error + 1e-14);
        CHECK(std::abs(m.area - 4 * pi * t * t) <= m.area_error + 1e-13);
        CHECK(m.volume_error < 1e-12);
        CHECK(m.min_clearance == doctest::Approx(1.5).epsilon(1e-14));
        CHECK(m.max_clearance == doctest::Approx(1.5).epsilon(1e-14));
        CHECK_FALSE(m.touches_box);
        if (!patches) continue;
        CHECK(cell.faces[0].bisector == "sphere");
        REQUIRE(cell.faces[0].patches.size() == 2);
        for (const TrimmedPatch& patch : cell.faces[0].patches)
            for (const Vec2& uv : {Vec2(0, 0), Vec2(0.5, -0.25), Vec2(-0.7, 0.7)})
                CHECK((patch.surface.evaluate(uv.x(), uv.y()) - Vec3(1, 2, 3)).norm() ==
                      doctest::Approx(t).epsilon(1e-14));
    }
}

// The solid angle in which a point at distance t from the base's centre is nearer to a tube at distance h
// from there than it is to the base: with y along the tube cos phi > k(y).
double shadow_of_tube(double t, double base, double h, double tube) {
    const double m = t - base + tube, s0 = (h - m) / t, y0 = std::sqrt(1 - s0 * s0);
    double sum = 0;
    constexpr int parts = 64;
    for (int i = 0; i < parts; ++i) {
        const double from = pi * (i / double(parts) - 0.5);
        sum += boost::math::quadrature::gauss<double, 30>::integrate(
            [&](double angle) {
                const double y = y0 * std::sin(angle), across = h * std::sqrt(1 - y * y);
                const double k = (t * t * (1 - y * y) + h * h - m * m) / (2 * t * across);
                return 2 * std::acos(std::min(1.0, k)) * y0 * std::cos(angle);
            },
            from, from + pi / parts);
    }
    return sum;
}

TEST_CASE("vessels: tubes cut their shadows off the sphere about a ball in the middle of another one") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 3; ++round) {
        CAPTURE(round);
        const Vec3 centre(unit(rng), unit(rng), unit(rng));
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(3 * unit(rng), Vec3(unit(rng), unit(rng), 1).normalized()).toRotationMatrix();
        Scene scene = in_sphere({centre, 0.5}, {centre, 3.5});
        const double h = 2.5 + 0.25 * unit(rng);
        scene.objects.push_back(Cylinder{centre + h * turn.col(0), turn.col(1), 0.25});
        double angle = 4 * pi - shadow_of_tube(2, 0.5, h, 0.25);
        if (round == 1) {
            scene.objects.push_back(Cylinder{centre - 2.25 * turn.col(0), turn.col(2), 0.125});
            angle -= shadow_of_tube(2, 0.5, 2.25, 0.125);
        } else if (round == 2) {
            // A ball's shadow is a cap: |2 u - 3 e| < 1.75.
            scene.objects.push_back(Sphere{centre - 3 * turn.col(0), 0.25});
            angle -= 2 * pi * (1 - (4 + 9 - 1.75 * 1.75) / 12);
        }
        CellOptions options;
        options.patches = false;
        const Cell cell = voronoi_cell(scene, options);
        const auto wall = std::ranges::find(cell.faces, Site::object(0), &CellFace::site);
        REQUIRE(wall != cell.faces.end());
        CHECK(std::abs(wall->area - 4 * angle) <= wall->area_error + 1e-10);
        CHECK(wall->area_error < 1e-3);
    }
}

TEST_CASE("vessels: about a ball off the middle the cell is a spheroid") {
    for (const double off : {1e-3, 0.25, 1.0, 2.5, 2.9}) {
        CAPTURE(off);
        const double R = 3, r = 0.125;
        CellOptions options;
        options.patches = false;
        const Cell cell = voronoi_cell(in_sphere({{off, 0, 0}, r}, {{0, 0, 0}, R}), options);
        REQUIRE(cell.faces.size() == 1);
        const double a = 0.5 * (R + r), b = 0.5 * std::sqrt((R + r) * (R + r) - off * off), e = off / (2 * a);
        const Measures& m = cell.measures;
        CHECK(m.volume == doctest::Approx(4 * pi / 3 * a * b * b).epsilon(1e-13));
        CHECK(m.area == doctest::Approx(2 * pi * b * (b + a * std::asin(e) / e)).epsilon(1e-13));
        CHECK(m.min_clearance == doctest::Approx(0.5 * (R - off - r)).epsilon(1e-13));
        CHECK(m.max_clearance == doctest::Approx(0.5 * (R + off - r)).epsilon(1e-13));
    }
}

TEST_CASE("vessels: a side of the box that touches the cell where it is farthest leaves it as far") {
    // Half-way between the base and the wall, behind the vessel's centre as the base sees it.
    Scene scene;
    scene.objects = {HollowSphere{{0.5, 0, 0}, 2}};
    scene.box = {Vec3(-3, -3, -1), Vec3(1.375, 3, 1)};
    const Object bases[] = {Sphere{{0, 0, 0}, 0.25}, Cylinder{{0, 0, 0}, {0, 0, 1}, 0.25}};
    for (const Object& base : bases) {
        scene.base = base;
        const Measures m = voronoi_cell(scene).measures;
        CHECK(std::abs(m.max_clearance - 1.125) <= m.max_clearance_error);
        CHECK(m.max_clearance_error < 1e-9);
    }
}

TEST_CASE(
    "vessels: where a vessel reaches out of another one by a rounding alone, its face is next to nothing") {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.25};
    const HollowSphere inner{{0.48423472977611937, -0.41885406205785264, -0.15347340679106208},
                             1.6064076222129953};
    scene.objects = {inner};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    const Cell alone = voronoi_cell(scene);
    // About 3e-9 around a place where both walls touch.
    scene.objects.push_back(
        HollowSphere{{0.5169368579555382, -0.6622544448374146, -0.09373113521479728}, 1.859157131683919});
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 2);
    CHECK(std::abs(cell.measures.volume - alone.measures.volume) < 1e-12);
    CHECK(cell.measures.volume_error < 1e-12);
    for (const CellFace& face : cell.faces) {
        CHECK(face.area_error < 1e-12);
        CHECK(std::abs(face.area - (face.site == Site::object(0) ? alone.faces[0].area : 0)) < 1e-12);
    }
}

TEST_CASE("vessels: sides of the box cut the spheroid as closed forms say") {
    // z <= h cuts the sphere of radius 2 about 0.
    Scene scene = in_sphere({{0, 0, 0}, 1}, {{0, 0, 0}, 3});
    const double h = 0.5, t = 2;
    scene.box.max.z() = h;
    const Cell cell = voronoi_cell(scene);
    CHECK(cell.faces.size() == 2);
    const double cap = pi * (t - h) * (t - h) * (3 * t - (t - h)) / 3;
    CHECK(std::abs(cell.measures.volume - (4 * pi / 3 * t * t * t - cap)) <=
          cell.measures.volume_error + 1e-13);
    CHECK(std::abs(cell.measures.area - 2 * pi * t * (t + h)) <= cell.measures.area_error + 1e-13);
    CHECK(cell.measures.box_area == doctest::Approx(pi * (t * t - h * h)).epsilon(1e-13));
    CHECK(cell.measures.max_clearance == doctest::Approx(1).epsilon(1e-14));
}

// The part of a spheroid on the side x <= h: its foci, the sum of the distances from both.
std::array<double, 2> part_of_spheroid(const Vec3& from, const Vec3& to, double sum, double h) {
    const double off = (to - from).norm(), a = 0.5 * sum, b = 0.5 * std::sqrt(sum * sum - off * off);
    const Vec3 e = (to - from) / off, middle = 0.5 * (from + to);
    // It is the unit ball stretched by A, and planes across x are planes across `pole` there.
    const Eigen::Matrix3d along = e * e.transpose(), across = Eigen::Matrix3d::Identity() - along;
    const Vec3 stretched = a * along.col(0) + b * across.col(0), pole = stretched.normalized();
    const double q = std::clamp((h - middle.x()) / stretched.norm(), -1.0, 1.0);
    const Vec3 u = pole.unitOrthogonal(), v = pole.cross(u);
    const Eigen::Matrix3d cofactors = b * b * along + a * b * across;
    const auto ring = [&](double z) {  // the trapezoidal rule of a periodic function
        constexpr int places = 128;
        double total = 0;
        for (int i = 0; i < places; ++i) {
            const double angle = 2 * pi * i / places, r = std::sqrt(1 - z * z);
            total += (cofactors * (z * pole + r * std::cos(angle) * u + r * std::sin(angle) * v)).norm();
        }
        return 2 * pi / places * total;
    };
    return {pi * a * b * b * (2 + 3 * q - q * q * q) / 3,
            boost::math::quadrature::gauss<double, 60>::integrate(ring, -1.0, q)};
}

TEST_CASE("vessels: edges through the far pole of a sphere's wall, and beside it, leave all digits") {
    const Vec3 center(0.1, 0.2, -0.3), direction = Vec3(3, 4, -12) / 13;
    const double R = 3, r = 0.125;
    for (const double off : {2.5, 1.0, 1e-3, 1e-10, 3e-16}) {
        const Vec3 base = center - off * direction;
        const double pole = base.x() + 0.5 * (R + r + off) * direction.x();
        for (const double beside : {0.0, 1e-12, -1e-9, 1e-6, -1e-3, 0.1, -0.25}) {
            CAPTURE(off);
            CAPTURE(beside);
            Scene scene = in_sphere({base, r}, {center, R});
            scene.box.max.x() = pole + beside;
            CellOptions options;
            options.patches = false;
            const Measures m = voronoi_cell(scene, options).measures;
            const auto [volume, area] = part_of_spheroid(base, center, R + r, pole + beside);
            CHECK(std::abs(m.volume - volume) <= m.volume_error + 1e-12);
            CHECK(std::abs(m.area - area) <= m.area_error + 1e-11);
            CHECK(m.volume_error < 1e-9);
            CHECK(m.area_error < 1e-8);
            CHECK(m.max_clearance <= 0.5 * (R + off - r) + 1e-14);
            if (beside >= 0) CHECK(m.max_clearance >= 0.5 * (R + off - r) - 1e-11);
        }
    }
}

TEST_CASE("vessels: random balls in a sphere, against distances alone") {
    std::mt19937_64 rng(test_seed());
    const HollowSphere vessel{{0.1, -0.2, 0.05}, 1};
    for (int round = 0; round < 4 * rounds(); ++round) {
        CAPTURE(round);
        const std::size_t count = round % 2 == 0 ? 6 : 40;
        const Scene scene = packed(rng, vessel, count, {{-1, -1.25, -1}, {1.125, 1, 1.125}});
        const Cell cell = voronoi_cell(scene);
        check_volume(scene, cell);
        check_vertices(cell);
        check_queries(scene, rng, 100);
    }
}

TEST_CASE("vessels: cells of the same balls in another order and place are the same") {
    std::mt19937_64 rng(test_seed());
    for (const Object& vessel :
         {Object(HollowSphere{{0, 0, 0}, 1}), Object(HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1})}) {
        const Scene scene = packed(rng, vessel, 25, {{-1, -1, -0.75}, {1, 1, 0.75}});
        const Cell cell = voronoi_cell(scene);
        Scene other = scene;
        std::vector<std::uint32_t> order(scene.objects.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
        std::ranges::shuffle(order, rng);
        const Vec3 way(4, -2, 8);  // exact, but for the last digits of coordinates
        const auto moved = [&](Object o) {
            if (auto* x = std::get_if<Sphere>(&o)) x->center += way;
            if (auto* x = std::get_if<HollowSphere>(&o)) x->center += way;
            if (auto* x = std::get_if<HollowCylinder>(&o)) x->point += way;
            return o;
        };
        other.base = moved(scene.base);
        for (std::size_t i = 0; i < order.size(); ++i) other.objects[i] = moved(scene.objects[order[i]]);
        other.box = {scene.box.min + way, scene.box.max + way};
        const Cell same = voronoi_cell(other);
        CHECK(same.vertices.size() == cell.vertices.size());
        CHECK(same.edges.size() == cell.edges.size());
        CHECK(same.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-10));
        std::set<std::uint32_t> neighbors;
        for (const std::uint32_t n : same.neighbors) neighbors.insert(order[n]);
        CHECK(neighbors == owners(cell));
    }
}

TEST_CASE("vessels: ties of small integers are decided") {
    // Points about a point in a sphere: the wall's bisector is |p| = 3/2, which meets x = 1, y = 1 and the
    // side z = 1/2 in one vertex.
    Scene scene = in_sphere({{0, 0, 0}, 0}, {{0, 0, 0}, 3});
    for (const Vec3& p : {Vec3(2, 0, 0), Vec3(-2, 0, 0), Vec3(0, 2, 0), Vec3(0, -2, 0)})
        scene.objects.push_back(Sphere{p, 0});
    scene.box = {{-4, -4, -0.5}, {4, 4, 0.5}};
    const Cell cell = voronoi_cell(scene);
    int four = 0;
    for (const CellVertex& v : cell.vertices) {
        CHECK(v.radius == doctest::Approx(1.5).epsilon(1e-14));
        CHECK(v.sites.size() == 4);
        four += v.sites.size() == 4;
    }
    CHECK(four == 8);
    for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
        const auto refined = refine(cell, i, 200);
        REQUIRE(refined);
        CHECK(refined->tie_width < 1e-50);
    }
    CHECK(cell.report.decisions.assumed == 0);
    CHECK(cell.measures.volume == doctest::Approx(4).epsilon(1e-12));  // the wall touches it in its corners

    // Balls that touch the wall from within, and the base.
    Scene touching = in_sphere({{0, 0, 0}, 1}, {{0, 0, 0}, 3});
    for (const Vec3& p : {Vec3(2, 0, 0), Vec3(-2, 0, 0), Vec3(0, 2, 0), Vec3(0, -2, 0)})
        touching.objects.push_back(Sphere{p, 1});
    const Cell touched = voronoi_cell(touching);
    CHECK(owners(touched) == std::set<std::uint32_t>{0, 1, 2, 3, 4});
    check_volume(touching, touched);
    check_vertices(touched);
    // A ball that touches the base, the wall and, beyond it, nothing; one beyond the wall is hidden.
    touching.objects.push_back(Sphere{{0, 0, 5}, 2});
    const Cell hidden = voronoi_cell(touching);
    CHECK(hidden.measures.volume == doctest::Approx(touched.measures.volume).epsilon(1e-13));
    CHECK(owners(hidden) == owners(touched));
    CHECK_FALSE(hidden.report.warnings.empty());
}

TEST_CASE("vessels: balls that overlap the wall have cells, those beyond it have none") {
    const auto cell_at = [](double x) { return voronoi_cell(in_sphere({{x, 0, 0}, 0.5}, {{0, 0, 0}, 2})); };
    const Cell cell = cell_at(1.75);
    CHECK(cell.measures.min_clearance == doctest::Approx(0.5 * (2 - 1.75 - 0.5)).epsilon(1e-14));
    CHECK_NOTHROW(cell_at(2.4375));
    for (const double x : {2.5, 3.0}) {
        CAPTURE(x);
        try {
            Scene far = in_sphere({{x, 0, 0}, 0.5}, {{0, 0, 0}, 2});
            far.box.max.x() = 4;
            voronoi_cell(far);
            FAIL("has a cell");
        } catch (const InputError& e) {
            CHECK(e.kind == InputError::Kind::TouchesBase);
            CHECK(e.path == "objects[0].hollow_sphere");
        }
    }
}

TEST_CASE("vessels: what is not supported is refused by name") {
    using Kind = InputError::Kind;
    Scene scene = in_sphere({{0, 0, 0}, 0.5}, {{0, 0, 0}, 2});
    Scene base = scene;
    base.base = HollowSphere{{0, 0, 0}, 2};
    CHECK(complaint(base) == "base.hollow_sphere" + kind(Kind::Unsupported));
    Scene flat = scene;
    flat.objects[0] = HollowSphere{{0, 0, 0}, 0};
    CHECK(complaint(flat) == "objects[0].hollow_sphere.radius" + kind(Kind::NegativeRadius));
    flat.objects[0] = HollowCylinder{{0, 0, 0}, {0, 0, 0}, 1};
    CHECK(complaint(flat) == "objects[0].hollow_cylinder.axis" + kind(Kind::ZeroAxis));
}

// ---- Tubes ----------------------------------------------------------------------------------------------

TEST_CASE("vessels: a ball on the axis of a tube, between sides of the box") {
    // r = (D^2 - z^2) / (2 D) from the axis, D the sum of the radii: across the axis the cell is a disc of
    // that radius without what is beyond x = -b and y = -c.
    const double D = 2.5, h = 1.5, b = 0.25, c = 0.5;
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.5};
    scene.objects = {HollowCylinder{{0, 0, 7}, {0, 0, 2}, 2}};
    scene.box = {{-b, -c, -h}, {3, 3, h}};
    const Cell cell = voronoi_cell(scene);
    check_volume(scene, cell);
    check_vertices(cell);
    const auto disc = [&](double z) {
        const double r = (D * D - z * z) / (2 * D);
        const auto strip = [&](double x) {  // of the half disc, between 0 and x
            return 0.5 * (x * std::sqrt(r * r - x * x) + r * r * std::asin(x / r));
        };
        return 0.25 * pi * r * r + strip(b) + strip(c) + b * c;
    };
    double volume = 0;  // Simpson's rule
    constexpr int parts = 400;
    for (int i = 0; i <= parts; ++i)
        volume += disc(-h + 2 * h * i / parts) * (i == 0 || i == parts ? 1 : i % 2 == 1 ? 4 : 2);
    volume *= 2 * h / parts / 3;
    CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error + 1e-9);
    CHECK(cell.measures.volume_error < 1e-6);
    CHECK(cell.measures.min_clearance == doctest::Approx(b - 0.5).epsilon(1e-12));
}

TEST_CASE("vessels: a ball's cell may reach all around the axis of a tube") {
    const double D = 2.5, h = 1.5;
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.5};
    scene.objects = {HollowCylinder{{0, 0, 7}, {0, 0, 2}, 2}};
    scene.box = {{-4, -4, -h}, {4, 4, h}};
    const Cell cell = voronoi_cell(scene);
    // The integral of pi (D^2 - z^2)^2 / (2 D)^2.
    const double D2 = D * D, h2 = h * h,
                 volume = pi / (2 * D2) * h * (D2 * D2 - 2 * D2 * h2 / 3 + h2 * h2 / 5);
    CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error + 1e-12);
    CHECK(cell.measures.volume_error < 1e-6);
    CHECK(cell.edges.size() == 2);
    CHECK(cell.vertices.empty());
}

TEST_CASE("vessels: random balls in a tube, against distances alone") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 4 * rounds(); ++round) {
        CAPTURE(round);
        const HollowCylinder vessel = round % 2 == 0 ? HollowCylinder{{0.05, 0, 3}, {0, 0, -2}, 1}
                                                     : HollowCylinder{{0.05, 0, 0}, Vec3(0.25, -0.125, 1), 1};
        const Scene scene = packed(rng, vessel, 30, {{-1.25, -1.25, -0.75}, {1.25, 1.25, 0.75}});
        const Cell cell = voronoi_cell(scene);
        check_volume(scene, cell);
        check_vertices(cell);
        check_queries(scene, rng, 100);
    }
}

TEST_CASE("vessels: vertices at walls are refined as others are") {
    std::mt19937_64 rng(test_seed());
    for (const Object& vessel :
         {Object(HollowSphere{{0, 0, 0}, 1}), Object(HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1})}) {
        Scene scene = packed(rng, vessel, 25, {{-1, -1, -0.75}, {1, 1, 0.75}});
        // The ball that is nearest to the wall.
        const auto nearest = std::ranges::min_element(scene.objects, {}, [&](const Object& o) {
            const auto* ball = std::get_if<Sphere>(&o);
            return ball != nullptr ? away(vessel, ball->center) - ball->radius : 1;
        });
        std::swap(scene.base, *nearest);
        const Cell cell = voronoi_cell(scene);
        const auto wall = static_cast<std::uint32_t>(scene.objects.size() - 1);
        int refined = 0;
        for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
            const auto& sites = cell.vertices[i].sites;
            if (std::ranges::find(sites, Site::object(wall)) == sites.end()) continue;
            CHECK(refine(cell, i, 200).has_value());
            ++refined;
        }
        CHECK(refined > 0);
    }
}

// ---- Whole diagrams -------------------------------------------------------------------------------------

TEST_CASE("vessels: a silo's diagram fills what is nearer to balls than to walls") {
    std::mt19937_64 rng(test_seed());
    const HollowCylinder wall{{0, 0, 0}, {0, 0, 1}, 1};
    const Scene scene = packed(rng, wall, 60, {{-1.25, -1.25, 0}, {1.25, 1.25, 1.5}});
    DiagramScene silo;
    silo.objects = scene.objects;
    silo.objects.push_back(scene.base);
    silo.objects.push_back(Plane{{0, 0, 0}, {0, 0, 1}});
    silo.objects.push_back(Sphere{{1.25, 1.25, 0.5}, 0.125});
    silo.names.assign(silo.objects.size(), "");
    silo.names[scene.objects.size() - 1] = "wall";
    silo.box = {{-1.25, -1.25, -0.25}, {1.25, 1.25, 1.5}};
    const VoronoiDiagram diagram = voronoi_diagram(silo);
    double sum = 0, error = 0;
    std::size_t walls = 0;
    for (std::size_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        const bool is_ball = std::holds_alternative<Sphere>(silo.objects[i]),
                   is_wall = is_vessel(silo.objects[i]);
        CAPTURE(i);
        CAPTURE(cell.reason);
        if (i + 1 == diagram.cells.size()) {
            CHECK(cell.state == DiagramCell::State::Empty);
            continue;
        }
        CHECK(cell.state == (is_wall ? DiagramCell::State::Wall : DiagramCell::State::Computed));
        walls += is_wall;
        if (!is_ball) continue;
        sum += cell.volume;
        error += cell.volume_error;
    }
    CHECK(walls == 1);
    const ContactTable table = contacts(diagram);
    CHECK(table.faults.empty());
    const auto wall_number = static_cast<std::uint32_t>(scene.objects.size() - 1);
    const auto at_wall = std::ranges::count_if(table.contacts, [&](const Contact& c) {
        return c.first == wall_number || c.second == Site::object(wall_number);
    });
    CHECK(at_wall > 10);
    check_share_of_balls(silo.objects, silo.box, sum, error, rng);
}

}  // namespace
}  // namespace vcell::vessels_test
