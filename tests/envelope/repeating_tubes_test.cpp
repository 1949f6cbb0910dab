// Tubes, planes and pipes in boxes that repeat: against counts of points, 27 copies, and volumes by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../../envelope/whole/own_periods.hpp"
#include "../test_support.hpp"
#include "diagram_checks.hpp"

namespace vcell::repeating_tubes_test {
namespace {

using State = DiagramCell::State;
using whole::Image;

DiagramScene cube(double edge, const std::array<bool, 3>& periodic = {true, true, true}) {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(edge)};
    scene.periodic = periodic;
    return scene;
}

// Along the edges, or diagonals of these, that repeat; or, where there is one, out of the box.
Cylinder random_tube(std::mt19937_64& rng, const DiagramScene& scene, bool leaves) {
    std::uniform_real_distribution<double> unit(0, 1);
    std::uniform_int_distribution<int> number(-1, 1);
    Vec3 along = Vec3::Zero();
    while (along.isZero(0))
        for (int k = 0; k < 3; ++k) along[k] = scene.periodic[k] ? number(rng) : 0;
    along = scene.edges() * along;
    if (leaves)
        for (int k = 0; k < 3; ++k) along[k] += scene.periodic[k] ? 0 : 2;
    const Vec3 place = scene.box.min + scene.edges() * Vec3(unit(rng), unit(rng), unit(rng));
    return {place, along, 0.1 * unit(rng)};
}

DiagramScene random_scene(std::mt19937_64& rng, DiagramScene scene) {
    std::uniform_real_distribution<double> unit(0, 1);
    const bool has_ends = !(scene.periodic[0] && scene.periodic[1] && scene.periodic[2]);
    for (int i = 0; i < 4; ++i)
        scene.objects.emplace_back(
            Sphere{scene.box.min + 2 * Vec3(unit(rng), unit(rng), unit(rng)), 0.2 * unit(rng)});
    for (int i = 0; i < 3; ++i) scene.objects.emplace_back(random_tube(rng, scene, has_ends && i == 0));
    return scene;
}

// Moved by edges of the box, by so many for each object.
DiagramScene moved(DiagramScene scene, const std::vector<Image>& by) {
    for (std::size_t i = 0; i < by.size(); ++i) {
        const Vec3 way = scene.edges() * Vec3(by[i][0], by[i][1], by[i][2]);
        if (auto* ball = std::get_if<Sphere>(&scene.objects[i])) ball->center += way;
        if (auto* tube = std::get_if<Cylinder>(&scene.objects[i])) tube->point += way;
    }
    return scene;
}

void check_filled(const DiagramScene& scene, const VoronoiDiagram& diagram) {
    for (const DiagramCell& cell : diagram.cells) {
        CAPTURE(cell.reason);
        CHECK((cell.state == State::Computed || cell.state == State::Empty));
    }
    CHECK(contacts(diagram).faults == std::vector<std::string>());
    const FilledVolume sum = filled_volume(scene, diagram);
    CAPTURE(sum.volume);
    CAPTURE(sum.error);
    CHECK(sum.fills());
    CHECK(sum.error < 1e-5 * sum.box);
}

}  // namespace

TEST_CASE("repeating tubes: random ones among balls fill the box, in any box") {
    std::mt19937_64 rng(test_seed());
    DiagramScene box = cube(2);
    SUBCASE("along all axes") {}
    SUBCASE("leaning") { box.tilt = {0.5, -0.25, 0.75}; }
    SUBCASE("along one axis") { box.periodic = {false, true, false}; }
    SUBCASE("along two axes") { box.periodic = {true, false, true}; }
    int refused = 0;
    for (int round = 0; round < rounds(); ++round) {
        const DiagramScene scene = random_scene(rng, box);
        CAPTURE(round);
        const VoronoiDiagram diagram = voronoi_diagram(scene);
        if (std::ranges::any_of(diagram.cells, touches_from_within)) {
            ++refused;
            continue;
        }
        check_filled(scene, diagram);
        check_sampled(scene, diagram, rng);
    }
    CHECK(8 * refused <= rounds());
}

TEST_CASE("repeating tubes: their cells are those among 27 copies") {
    // Tubes along edges, so that copies of a tube are copies of its cell's pieces.
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(0, 1);
    DiagramScene scene = cube(1);
    for (int i = 0; i < 3; ++i)
        scene.objects.emplace_back(Sphere{Vec3(unit(rng), unit(rng), unit(rng)), 0.1 * unit(rng)});
    for (int k = 0; k < 3; ++k)
        scene.objects.emplace_back(Cylinder{Vec3(unit(rng), unit(rng), unit(rng)), Vec3::Unit(k), 0.05});
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    check_filled(scene, diagram);

    DiagramScene copies = cube(3);
    std::vector<std::uint32_t> whose;
    std::vector<double> shares(scene.objects.size(), 0), areas = shares, errors = shares;
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            for (int c = 0; c < 3; ++c)
                for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
                    const Image by{static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                   static_cast<std::int16_t>(c)};
                    if (i >= 3 && by[i - 3] != 0) continue;  // it is a copy along the tube
                    DiagramScene one = scene;
                    one.objects = {scene.objects[i]};
                    copies.objects.push_back(moved(one, {by}).objects[0]);
                    whose.push_back(i);
                }
    const VoronoiDiagram all = voronoi_diagram(copies);
    check_filled(copies, all);
    for (std::size_t k = 0; k < whose.size(); ++k) {
        const DiagramCell& cell = all.cells[k];
        shares[whose[k]] += cell.volume / 27;
        areas[whose[k]] += cell.area / 27;
        errors[whose[k]] += (cell.volume_error + cell.area_error) / 27;
    }
    for (std::size_t i = 0; i < shares.size(); ++i) {
        CAPTURE(i);
        const DiagramCell& cell = diagram.cells[i];
        CHECK(std::abs(shares[i] - cell.volume) <= errors[i] + cell.volume_error);
        CHECK(std::abs(areas[i] - cell.area) <= errors[i] + cell.area_error);
        CHECK(cell.area > 0);
    }
}

TEST_CASE("repeating tubes: an image of an object is as good as the object") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> edges(-20, 20);
    for (const bool leans : {false, true}) {
        DiagramScene box = cube(2);
        if (leans) box.tilt = {0.5, -0.25, 0.75};
        const DiagramScene scene = random_scene(rng, box);
        std::vector<Image> by;
        for (std::size_t i = 0; i < scene.objects.size(); ++i)
            by.push_back({static_cast<std::int16_t>(edges(rng)), static_cast<std::int16_t>(edges(rng)),
                          static_cast<std::int16_t>(edges(rng))});
        const VoronoiDiagram diagram = voronoi_diagram(scene), other = voronoi_diagram(moved(scene, by));
        REQUIRE(diagram.periods == other.periods);
        // Places far away are on a coarser grid; areas and lengths are less than the box's edges tell.
        const double moved_by = 24 * (diagram.moved + other.moved);
        const std::vector<Contact> one = contacts(diagram).contacts;
        std::vector<Contact> two = contacts(other).contacts;
        REQUIRE(one.size() == two.size());
        // What the second sees of the first is moved by where both are.
        for (const Contact& c : one) {
            std::vector<Image> periods;
            for (const ObjectImage& p : diagram.periods)
                if (p.number == c.first || p.number == c.second.index) periods.push_back(p.image);
            const auto same = std::ranges::find_if(two, [&](const Contact& d) {
                if (d.first != c.first || d.second != c.second) return false;
                std::array<Image, 2> sign{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const int way = by[c.first][k] - by[c.second.index][k];
                    sign[0][k] = static_cast<std::int16_t>(c.image[k] + way);
                    sign[1][k] = static_cast<std::int16_t>(-c.image[k] + way);
                }
                const Image there = whole::representative(d.image, periods);
                return there == whole::representative(sign[0], periods) ||
                       (c.first == c.second.index && there == whole::representative(sign[1], periods));
            });
            REQUIRE(same != two.end());
            CHECK(std::abs(same->area - c.area) <= same->area_error + c.area_error + moved_by);
            two.erase(same);
        }
        for (std::size_t i = 0; i < scene.objects.size(); ++i)
            CHECK(std::abs(diagram.cells[i].volume - other.cells[i].volume) <=
                  diagram.cells[i].volume_error + other.cells[i].volume_error + moved_by);
    }
}

TEST_CASE("repeating tubes: one among its own images has all of the box, and its body what a period has") {
    struct Case {
        Vec3 axis;
        std::size_t neighbors;  // pairs of opposite images
    };
    for (const auto& [axis, neighbors] :
         {Case{{0, 0, 1}, 2}, Case{{1, 1, 0}, 2}, Case{{1, 1, 1}, 3}, Case{{1, 2, 0}, 2}})
        for (const double radius : {0.0, 0.125, 0.25}) {
            CAPTURE(axis.transpose());
            CAPTURE(radius);
            DiagramScene scene = cube(1);
            scene.objects = {Cylinder{{0.5, 0.25, 0.75}, -2.5 * axis, radius}};
            DiagramOptions options;
            options.bodies = true;
            const VoronoiDiagram diagram = voronoi_diagram(scene, options);
            check_filled(scene, diagram);
            CHECK(contacts(diagram).contacts.size() == neighbors);
            const DiagramCell& cell = diagram.cells[0];
            CHECK(std::abs(cell.volume - 1) <= cell.volume_error);
            if (radius == 0) continue;
            const double body = std::numbers::pi * radius * radius * axis.norm();
            // Of (1, 2, 0) images lie in each other.
            if (axis.y() < 2 || radius < 0.2)
                CHECK(std::abs(cell.body_volume - body) <= cell.body_error + 1e-15);
        }
}

TEST_CASE("repeating tubes: packings of rods have equal cells, whose faces are where they are known") {
    // Three rods along the axes that keep clear of each other [O'Keeffe and Andersson 1977].
    DiagramScene scene = cube(2);
    scene.objects = {Cylinder{{0, 1, 0}, {1, 0, 0}, 0.25}, Cylinder{{0, 0, 1}, {0, 1, 0}, 0.25},
                     Cylinder{{1, 0, 0}, {0, 0, 1}, 0.25}};
    const VoronoiDiagram rods = voronoi_diagram(scene);
    check_filled(scene, rods);
    for (const DiagramCell& cell : rods.cells)
        CHECK(std::abs(cell.volume - 8.0 / 3) <= cell.volume_error + 1e-12);
    // Plies across each other: the plane between them is not between the tubes of one ply.
    scene.objects = {Cylinder{{0, 0, 0}, {1, 0, 0}, 0.125}, Cylinder{{0, 0, 1}, {0, 1, 0}, 0.125}};
    const VoronoiDiagram plies = voronoi_diagram(scene);
    check_filled(scene, plies);
    for (const DiagramCell& cell : plies.cells) CHECK(std::abs(cell.volume - 4) <= cell.volume_error);
}

// Between a ball and a tube of its radius is a parabolic cylinder. Where the tube is halfway to an image of
// the ball two of them meet in a line, along which the plane halfway to another image, or a side of the box,
// ties.
TEST_CASE("repeating tubes: a ball's faces with two of them meet where it ties with a plane") {
    const auto check_thirds = [](const DiagramScene& scene) {
        const VoronoiDiagram diagram = voronoi_diagram(scene);
        check_whole(scene, diagram);
        const DiagramCell &ball = diagram.cells[0], &tube = diagram.cells[1];
        CHECK(std::abs(ball.volume - 8.0 / 3) <= ball.volume_error);
        CHECK(std::abs(tube.volume - 16.0 / 3) <= tube.volume_error);
        return ball.contacts.size();
    };
    DiagramScene scene = cube(2, {true, false, false});
    scene.objects = {Sphere{{0, 1, 1}, 0.25}, Cylinder{{1, 1, 1}, {0, 1, 0}, 0.25}};
    CHECK(check_thirds(scene) == 4);  // the tube on two sides, and two sides of the box
    for (const bool repeats_all : {false, true}) {
        CAPTURE(repeats_all);
        scene.periodic = {true, true, repeats_all};
        check_thirds(scene);
    }
    // Parallel tubes that lean, around a box of the same planes.
    scene.periodic = {true, true, true};
    std::get<Cylinder>(scene.objects[1]).axis = {0, 1, 1};
    check_whole(scene, voronoi_diagram(scene));
    std::get<Cylinder>(scene.objects[1]).radius = 0.125;
    check_whole(scene, voronoi_diagram(scene));
}

TEST_CASE("repeating tubes: what lies in an image, or equals one, has no cell") {
    DiagramScene scene = cube(2);
    scene.objects = {Cylinder{{0.25, 0.5, 0}, {1, 1, 0}, 0.25},
                     Cylinder{{1.25, 1.5, 2}, {-2, -2, 0}, 0.25},   // the first, moved along itself
                     Cylinder{{0.25, -1.5, -2}, {1, 1, 0}, 0.125},  // in an image of it
                     Sphere{{3.25, 1.5, 4.125}, 0.125},             // in another one
                     Sphere{{1, 0.25, 1}, 0.25}};
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    check_filled(scene, diagram);
    CHECK(diagram.cells[1].reason == "equals object 0");
    CHECK(diagram.cells[2].reason == "lies in object 0");
    CHECK(diagram.cells[3].reason == "lies in object 0");
    CHECK(diagram.cells[0].state == State::Computed);
}

TEST_CASE(
    "repeating tubes: balls in a slit between planes, and in a pipe, leave nothing but what walls have") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(0, 1);
    DiagramScene slit = cube(4, {true, true, false});
    slit.objects = {Plane{{0, 0, 0.25}, {0, 0, 1}}, Plane{{1, 2, 3.75}, {0, 0, -2}}};
    for (int i = 0; i < 12; ++i)
        slit.objects.emplace_back(
            Sphere{Vec3(4 * unit(rng), 4 * unit(rng), 1 + 2 * unit(rng)), 0.5 * unit(rng)});
    slit.objects.emplace_back(Cylinder{{1, 1, 2}, {1, 0, 0}, 0.125});
    const VoronoiDiagram diagram = voronoi_diagram(slit);
    check_filled(slit, diagram);
    check_sampled(slit, diagram, rng);

    DiagramScene pipe = cube(4, {false, false, true});
    pipe.objects = {HollowCylinder{{2, 2, 0}, {0, 0, 1}, 1.75}, Cylinder{{2, 2.5, 0}, {0, 0, 1}, 0.5}};
    const VoronoiDiagram ring = voronoi_diagram(pipe);
    CHECK(contacts(ring).faults == std::vector<std::string>());
    // Of the axes and half of the radii together is the ellipse that ends the tube's cell.
    const double half = 0.5 * (1.75 + 0.5), other = std::sqrt(half * half - 0.25 * 0.25);
    CHECK(ring.cells[1].volume == doctest::Approx(4 * std::numbers::pi * half * other).epsilon(1e-12));
}

TEST_CASE("repeating tubes: update() is the diagram anew") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 3; ++round) {
        DiagramScene scene = random_scene(rng, cube(2));
        VoronoiDiagram diagram = voronoi_diagram(scene);
        const Cylinder tube = random_tube(rng, scene, false);
        for (const std::uint32_t number : {1U, 5U}) {
            update(diagram, scene, number, tube);
            const VoronoiDiagram anew = voronoi_diagram(scene);
            CHECK(diagram.periods == anew.periods);
            check_alike(diagram, anew);
        }
    }
}

TEST_CASE("repeating tubes: cells are the same for any number of threads, with and without faces") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = random_scene(rng, cube(2));
    DiagramOptions options;
    options.threads = 1;
    const VoronoiDiagram one = voronoi_diagram(scene, options);
    options.threads = 3;
    options.complete = true;
    std::vector<std::uint32_t> visited;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        visited.push_back(object);
        CHECK(!cell.faces.empty());
    };
    const VoronoiDiagram other = voronoi_diagram(scene, options);
    CHECK(visited.size() == scene.objects.size());
    check_alike(one, other);
}

TEST_CASE("repeating tubes: what does not fit into a box that repeats is named") {
    DiagramScene scene = cube(2);
    scene.objects = {Sphere{{1, 1, 1}, 0.5}, Cylinder{{0, 0, 0}, {1, std::numbers::sqrt2, 0}, 0.125}};
    CHECK_THROWS_WITH_AS(voronoi_diagram(scene), doctest::Contains("objects[1].cylinder.axis"), InputError);
    scene.periodic[1] = false;  // there it leaves the box
    check_filled(scene, voronoi_diagram(scene));
    scene.objects[1] = Plane{{0, 0, 0}, {1, 0, 0}};
    CHECK_THROWS_WITH_AS(voronoi_diagram(scene), doctest::Contains("objects[1].plane"), InputError);
    scene.objects[1] = HollowSphere{{1, 1, 1}, 3};
    CHECK_THROWS_WITH_AS(voronoi_diagram(scene), doctest::Contains("objects[1]"), InputError);
}

TEST_CASE("representative: one of each class of images, whatever the order of periods") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> number(-3, 3), many(-50, 50);
    const auto image = [&](auto& of) {
        return Image{static_cast<std::int16_t>(of(rng)), static_cast<std::int16_t>(of(rng)),
                     static_cast<std::int16_t>(of(rng))};
    };
    for (int round = 0; round < 2000; ++round) {
        std::vector<Image> periods(static_cast<std::size_t>(round % 4));
        for (Image& p : periods) p = image(number);
        const Image one = image(many);
        Image other = one;
        for (const Image& p : periods) {
            const int times = number(rng);
            for (std::size_t k = 0; k < 3; ++k) other[k] = static_cast<std::int16_t>(other[k] + times * p[k]);
        }
        const Image stands = whole::representative(one, periods);
        CHECK(whole::representative(other, periods) == stands);
        CHECK(whole::representative(stands, periods) == stands);
        // In whatever form the periods are given.
        std::vector<Image> more = periods;
        if (more.size() > 1) {
            for (std::size_t k = 0; k < 3; ++k)
                more[0][k] = static_cast<std::int16_t>(more[0][k] + 2 * more[1][k]);
            std::swap(more.front(), more.back());
        }
        CHECK(whole::representative(one, more) == stands);
    }
    CHECK(whole::representative({1, 0, 0}, std::vector<Image>{{1, 1, 0}, {1, -1, 0}}) !=
          whole::representative({0, 0, 0}, std::vector<Image>{{1, 1, 0}, {1, -1, 0}}));
}

}  // namespace vcell::repeating_tubes_test
