// Where clearance is least and greatest: closed forms, rays of sampled points, the file and its check.
#include "../../envelope/measures/clearance_places.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <variant>

#include "../../envelope/point_query.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../test_support.hpp"
#include "boxed_scenes.hpp"
#include "damages.hpp"
#include "listing.hpp"
#include "random_scenes.hpp"
#include "sample_cells.hpp"

namespace vcell::clearance_places_test {

using namespace damages;

namespace {

void check_place(const std::optional<ClearancePlace>& place, const Vec3& point, double clearance,
                 std::vector<Site> sites) {
    REQUIRE(place);
    CHECK((place->point - point).norm() <= 1e-12);
    CHECK(place->error <= 1e-11);
    CHECK(std::abs(place->clearance - clearance) <= place->clearance_error + 1e-15);
    CHECK(place->clearance_error <= 1e-12);
    CHECK(place->sites == sites);
}

double distance(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object))
        return std::abs(plane->normal.dot(p - plane->point)) / plane->normal.norm();
    if (const auto* ball = std::get_if<Sphere>(&object)) return (p - ball->center).norm() - ball->radius;
    const auto& tube = std::get<Cylinder>(object);
    return (p - tube.point).cross(tube.axis).norm() / tube.axis.norm() - tube.radius;
}

/// By distances, and by the cell's boundary over sampled points of the box.
void check_sampled(const Cell& cell, std::mt19937_64& rng, int samples) {
    const Scene& scene = cell.scene;
    const ClearancePlaces places = clearance_places(cell);
    REQUIRE(places.least);
    REQUIRE(places.greatest);
    const double rounding = 1e-13 * scene.box.diagonal();
    for (const ClearancePlace& place : {*places.least, *places.greatest}) {
        const double own = distance(scene.base, place.point);
        CHECK(std::abs(own - place.clearance) <= 2 * place.error + rounding);
        CHECK(place.vertex.has_value() + place.edge.has_value() + place.face.has_value() <= 1);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            if (!scene.competes(i)) continue;
            const double more = distance(scene.objects[i], place.point) - own;
            CHECK(more >= -2 * place.error - rounding);
            if (std::ranges::count(place.sites, Site::object(scene.number(i))) > 0)
                CHECK(more <= 2 * place.error + rounding);
        }
        for (const Site site : place.sites) {
            if (site.kind != Site::Kind::BoxSide || place.sites.size() > 1) continue;
            const double side = (site.index % 2 == 1 ? scene.box.max : scene.box.min)[site.index / 2];
            CHECK(std::abs(place.point[site.index / 2] - side) <= place.error + rounding);
        }
    }
    PointQuery query(scene);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < samples; ++k) {
        const Vec3 p = scene.box.min +
                       (scene.box.max - scene.box.min).cwiseProduct(Vec3(unit(rng), unit(rng), unit(rng)));
        const auto answer = query(p);
        if (!answer || !answer->site) continue;
        CHECK(answer->clearance >= places.least->clearance - places.least->clearance_error - rounding);
        CHECK(answer->clearance <= places.greatest->clearance + places.greatest->clearance_error + rounding);
    }
    // No looser than the measures themselves and what holds the place.
    CHECK(places.least->clearance_error <=
          2 * cell.measures.min_clearance_error + 4 * places.least->error + rounding);
    CHECK(places.greatest->clearance_error <=
          2 * cell.measures.max_clearance_error + 4 * places.greatest->error + rounding);
}

}  // namespace

TEST_CASE("clearance places: head on between a base and an object") {
    const auto o = [](std::uint32_t i) { return std::vector<Site>{Site::object(i)}; };
    const Cell balls = voronoi_cell(scene_in_cube(Sphere{{0, 0, 0}, 1}, {Sphere{{4, 0, 0}, 0.5}}, 10));
    const ClearancePlaces of_balls = clearance_places(balls);
    check_place(of_balls.least, {2.25, 0, 0}, 1.25, o(0));
    CHECK(of_balls.least->face);
    CHECK(balls.faces[of_balls.least->face.value()].site == Site::object(0));
    REQUIRE(of_balls.greatest);
    CHECK(of_balls.greatest->vertex);  // a corner of the box
    CHECK(of_balls.greatest->clearance == doctest::Approx(std::sqrt(300.0) - 1));

    Scene under = scene_in_cube(Plane{{0, 0, 0}, {0, 0, 1}}, {Sphere{{0.25, 0.125, 0.875}, 0.25}}, 1);
    under.box.min.z() = 0;
    check_place(clearance_places(voronoi_cell(under)).least, {0.25, 0.125, 0.3125}, 0.3125, o(0));

    // Oblique tubes; and a plane along one, where a whole line is as near.
    const Cell tubes = voronoi_cell(
        scene_in_cube(Cylinder{{0, 0, 0}, {0, 1, 0}, 0.5}, {Cylinder{{0, 0.5, 3}, {1, 0, 0}, 0.5}}, 4));
    check_place(clearance_places(tubes).least, {0, 0.5, 1.5}, 1, o(0));
    const Cell along =
        voronoi_cell(scene_in_cube(Cylinder{{0, 0, 0}, {0, 1, 0}, 0.5}, {Plane{{0, 0, 2}, {0, 0, 1}}}, 4));
    const auto least = clearance_places(along).least;
    REQUIRE(least);
    CHECK(least->edge);
    CHECK(std::abs(least->clearance - 0.75) <= least->clearance_error + 1e-15);
    CHECK((least->point - Vec3(0, least->point.y(), 1.25)).norm() <= 1e-7);

    // The nearest side of the box is the nearest of all.
    Scene side = scene_in_cube(Sphere{{0, 0, 0}, 1}, {Sphere{{9, 0, 0}, 0.5}}, 10);
    side.box.min.y() = -2;
    check_place(clearance_places(voronoi_cell(side)).least, {0, -2, 0}, 1, {Site::box_side(2)});
}

TEST_CASE("clearance places: of the faces of one site the one that holds the place is told") {
    // A tube cuts the plane's face in two, on either side of the place.
    for (const double x : {-0.9, 0.9}) {
        CAPTURE(x);
        const Cell cell = voronoi_cell(scene_in_cube(
            Sphere{{0, 0, 0}, 0.5}, {Plane{{0, 0, 1}, {0, 0, 1}}, Cylinder{{x, 0, 1}, {0.1, 1, 0}, 0.2}}, 4));
        REQUIRE(std::ranges::count(cell.faces, Site::object(0), &CellFace::site) == 2);
        const auto least = clearance_places(cell).least;
        check_place(least, {0, 0, 0.75}, 0.25, {Site::object(0)});
        REQUIRE(least->face);
        const CellMesh mesh = tessellate(cell);
        double nearest = 1e300;
        std::uint32_t of_nearest = UINT32_MAX;
        for (const CellMesh::Group& group : mesh.groups)
            for (std::size_t t = group.begin; t < group.end; ++t)
                for (const std::uint32_t p : mesh.triangles[t])
                    if (const double off = (mesh.points[p] - least->point).norm(); off < nearest) {
                        nearest = off;
                        of_nearest = group.face;
                    }
        CHECK(least->face == of_nearest);
    }
}

TEST_CASE("clearance places: between balls that are all but one") {
    for (const char* name : {"ball_at_the_base", "points_and_ball_at_the_base"}) {
        CAPTURE(name);
        const Cell cell = voronoi_cell(read_scene(test_data(std::string("hostile/") + name + ".json")));
        const auto least = clearance_places(cell).least;
        REQUIRE(least);
        CHECK(least->face);
        CHECK(std::abs(least->clearance - cell.measures.min_clearance) <= least->clearance_error);
        CHECK(least->point.norm() <= least->error + 1e-15);
    }
}

TEST_CASE("clearance places: along a tube, where edges are told to no digits") {
    const Cell cell = voronoi_cell(read_scene(test_data("hostile/narrow_slit_along_tube.json")));
    const auto least = clearance_places(cell).least;
    REQUIRE(least);
    CHECK(least->face);
    CHECK(std::abs(least->clearance - 5e-9) <= 1e-15);
    CHECK(least->error < 1e-7);
}

TEST_CASE("clearance places: in vessels, where clearance is greatest inside of a face") {
    const std::vector<Site> wall{Site::object(0)};
    const ClearancePlaces ball =
        clearance_places(voronoi_cell(scene_in_cube(Sphere{{0, 0, 0}, 1}, {HollowSphere{{1, 0, 0}, 5}}, 10)));
    check_place(ball.least, {-2.5, 0, 0}, 1.5, wall);
    check_place(ball.greatest, {3.5, 0, 0}, 2.5, wall);

    const ClearancePlaces tip = clearance_places(
        voronoi_cell(scene_in_cube(Sphere{{0.5, 0, 0}, 1}, {HollowCylinder{{0, 0, 0}, {0, 0, 2}, 3}}, 10)));
    REQUIRE(tip.greatest);
    CHECK(tip.greatest->face);
    CHECK(
        (tip.greatest->point - Vec3(0, 0, std::copysign(std::sqrt(15.75), tip.greatest->point.z()))).norm() <=
        1e-12);
    CHECK(tip.greatest->clearance == doctest::Approx(3).epsilon(1e-12));
    check_place(tip.least, {2.25, 0, 0}, 0.75, wall);

    // About the middle all places are alike.
    const ClearancePlaces middle =
        clearance_places(voronoi_cell(scene_in_cube(Sphere{{0, 0, 0}, 1}, {HollowSphere{{0, 0, 0}, 5}}, 10)));
    for (const auto& place : {middle.least, middle.greatest}) {
        REQUIRE(place);
        CHECK(place->clearance == 2);
        CHECK(place->point.norm() == doctest::Approx(3));
    }

    // In a cone of half angle 30 degrees, at distance 4 from the apex: the wall is 2 away.
    const ClearancePlaces cone = clearance_places(
        voronoi_cell(scene_in_cube(Sphere{{0.5, 0, 0}, 1}, {HollowCone{{0, 0, -4}, {0, 0, 1}, 1, 2}}, 10)));
    REQUIRE(cone.least);
    const Vec3 out(std::sqrt(0.75), 0, -0.5);
    const double wall_away = 2 - std::sqrt(0.75) * 0.5;
    CHECK((cone.least->point - (Vec3(0.5, 0, 0) + 0.5 * (wall_away + 1) * out)).norm() <= 1e-12);
    CHECK(cone.least->face);
    REQUIRE(cone.greatest);
    // On the axis, as far from the wall as from the ball.
    const double tip_at = (3 + std::sqrt(35.25)) / 1.5;
    check_place(cone.greatest, {0, 0, tip_at}, 0.5 * (tip_at + 4), wall);
    CHECK(cone.greatest->face);
}

TEST_CASE("clearance places: a cap, and cells without any") {
    Scene scene = scene_in_cube(Sphere{{0, 0, 0}, 1}, {Sphere{{40, 0, 0}, 0.5}}, 50);
    scene.probe = 1.5;
    Cell cell = voronoi_cell(scene);
    const ClearancePlaces cap = clearance_places(cell);
    cell.clearance_places = cap;
    const Certificate certificate = certify(parse_cell(cell_text(cell)));
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
    REQUIRE(cap.greatest);
    CHECK(cap.greatest->sites == std::vector<Site>{Site::cap()});
    CHECK(cap.greatest->clearance == doctest::Approx(1.5).epsilon(1e-14));
    CellOptions bare;
    bare.measure = false;
    const ClearancePlaces none = clearance_places(voronoi_cell(scene, bare));
    CHECK_FALSE(none.least);
    CHECK_FALSE(none.greatest);
}

TEST_CASE("clearance places: of random cells and of cells of every kind") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 8 * rounds(); ++i) {
        CAPTURE(i);
        check_sampled(voronoi_cell(scene_about_ball(rng, 12, 2)), rng, 500);
        check_sampled(voronoi_cell(scene_over_plane(rng, 12, 2)), rng, 500);
    }
    for (const char* name : {"balls", "lattice", "atom", "tube lattice", "tubes over a plane",
                             "tubes around a tube", "around a cylinder"}) {
        CAPTURE(name);
        check_sampled(good(name), rng, 500);
    }
}

// A place over the rim is as far along the normal from where a side of the box meets the base, not from it.
TEST_CASE("clearance places: over the rim of a plane that leans they are not refuted") {
    Scene scene = scene_in_cube(
        Plane{{0, 0, 0}, {0.75, -0.125, 0.25}},
        {Sphere{{-1.25, 0.5, 1.25}, 0.25}, Sphere{{0.25, 0.875, 0.625}, 0.25}, Sphere{{-1.5, 1, 0.25}, 0.25}},
        2);
    scene.probe = 0.75;
    Cell cell = voronoi_cell(scene);
    cell.clearance_places = clearance_places(cell);
    const auto is_side = [](const Site& s) { return s.kind == Site::Kind::BoxSide; };
    REQUIRE(std::ranges::any_of(cell.clearance_places->greatest.value().sites, is_side));
    const Certificate right = certify(cell);
    CHECK_MESSAGE(right.holds(), listing(right));
    cell.clearance_places->greatest->point += 1e-3 * Vec3(0.125, 0.75, 0);
    CHECK_FALSE(certify(cell).holds());
}

TEST_CASE("clearance places: are those of the file, and the check does not pass wrong ones") {
    for (const char* name : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        CAPTURE(name);
        Cell with = good(name);
        CHECK_FALSE(parse_cell(cell_text(with)).clearance_places);
        with.clearance_places = clearance_places(with);
        const Cell cell = parse_cell(cell_text(with));
        REQUIRE(cell.clearance_places);
        const auto same = [](const ClearancePlace& a, const ClearancePlace& b) {
            return a.point == b.point && a.error == b.error && a.clearance == b.clearance &&
                   a.clearance_error == b.clearance_error && a.sites == b.sites && a.vertex == b.vertex &&
                   a.edge == b.edge && a.face == b.face;
        };
        CHECK(same(cell.clearance_places->least.value(), with.clearance_places->least.value()));
        CHECK(same(cell.clearance_places->greatest.value(), with.clearance_places->greatest.value()));
        const Certificate right = certify(cell);
        CHECK_MESSAGE(right.holds(), listing(right));
        const double size = cell.scene.box.diagonal();
        const auto expect = [&](const std::function<void(ClearancePlaces&)>& damage) {
            Cell bad = cell;
            damage(*bad.clearance_places);
            const Certificate certificate = certify(bad);
            CHECK_MESSAGE(std::ranges::any_of(certificate.elements,
                                              [](const Element& e) {
                                                  return e.verdict == Verdict::refuted &&
                                                         e.where.find("_clearance_place") !=
                                                             std::string::npos;
                                              }),
                          listing(certificate));
        };
        expect([&](ClearancePlaces& p) { p.least->point += 1e-3 * size * Vec3(1, 1, 1); });
        expect([&](ClearancePlaces& p) { p.greatest->point *= not_measured; });
        expect([&](ClearancePlaces& p) { p.greatest->clearance *= 1 + 1e-3; });
        expect([&](ClearancePlaces& p) { p.least->sites.push_back(Site::end(1)); });
        expect([&](ClearancePlaces& p) {
            p.greatest->vertex.reset();
            p.greatest->edge = static_cast<std::uint32_t>(cell.edges.size());
        });
        // A place of the boundary, but not of the extreme.
        expect([&](ClearancePlaces& p) { std::swap(p.least, p.greatest); });
    }
}

}  // namespace vcell::clearance_places_test
