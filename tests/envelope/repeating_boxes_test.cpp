// Boxes that repeat: balls beside them and far away, against counts of points and the same balls in the box.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"
#include "diagram_checks.hpp"

namespace vcell::repeating_boxes_test {
namespace {

using State = DiagramCell::State;

}  // namespace

TEST_CASE("voronoi_diagram: balls on and beyond sides of a box that repeats along others have their cells") {
    std::mt19937_64 rng(test_seed());
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(4)};
    const Sphere inside{{2, 1, 3}, 1};
    const std::vector<std::vector<Sphere>> beside{{{{2, 2, 0}, 1}},
                                                  {{{2, 2, -1}, 2}},
                                                  {{{0, 0, 0}, 0.5}, {{3, 3, 4}, 0}},
                                                  {{{1, 3, 6}, 3}, {{3, 0, 4}, 0}, {{3, 3, -1}, 0}}};
    for (const std::array<bool, 3> periodic : {std::array{true, false, false}, std::array{true, true, false}})
        for (const std::vector<Sphere>& others : beside) {
            CAPTURE(periodic[1]);
            CAPTURE(others.size());
            scene.periodic = periodic;
            scene.objects = {inside};
            scene.objects.insert(scene.objects.end(), others.begin(), others.end());
            const VoronoiDiagram diagram = voronoi_diagram(scene);
            check_whole(scene, diagram);
            check_sampled(scene, diagram, rng);
            // Only the ball inside the box has faces to look at.
            DiagramOptions options;
            options.complete = true;
            std::vector<std::uint32_t> visited;
            options.visit = [&](std::uint32_t object, const Cell&) { visited.push_back(object); };
            check_whole(scene, voronoi_diagram(scene, options));
            CHECK(std::ranges::find(visited, 0) != visited.end());
            // What is out of a probe's reach has no cell, and is no fault.
            DiagramScene probed = scene;
            probed.objects = {inside, Sphere{{2, 2, 7}, 1}};
            probed.probe = 1;
            const VoronoiDiagram near = voronoi_diagram(probed);
            CHECK(near.cells[0].state == State::Computed);
            CHECK(near.cells[1].state == State::Empty);
        }
}

TEST_CASE("voronoi_diagram: balls any number of edges away are images of balls in the box that repeats") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> place(0, 15), edges(-4000, 4000);
    for (const bool leans : {false, true}) {
        DiagramScene scene;
        scene.box = {{-1, 0, 2}, {3, 4, 6}};
        scene.periodic = {true, leans, true};
        if (leans) scene.tilt = {1, -1, 2};
        for (int i = 0; i < 12; ++i)
            scene.objects.push_back(Sphere{
                scene.box.min + 0.25 * Vec3(place(rng), place(rng) + 0.5, place(rng)), 0.0625 * place(rng)});
        DiagramScene far = scene;
        std::vector<std::array<int, 3>> by;
        for (Object& o : far.objects) {
            by.push_back({edges(rng), scene.periodic[1] ? edges(rng) : 0, edges(rng)});
            std::get<Sphere>(o).center += scene.edges() * Vec3(by.back()[0], by.back()[1], by.back()[2]);
        }
        const VoronoiDiagram diagram = voronoi_diagram(scene), other = voronoi_diagram(far);
        check_whole(far, other);
        std::size_t computed = 0;
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            const DiagramCell &a = diagram.cells[i], &b = other.cells[i];
            CAPTURE(i);
            REQUIRE(a.state == b.state);
            if (a.state != State::Computed) continue;
            ++computed;
            CHECK(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error);
            REQUIRE(a.contacts.size() == b.contacts.size());
            for (const CellContact& c : a.contacts) {
                std::array<std::int16_t, 3> image = c.image;
                if (c.site.is_object())
                    for (int k = 0; k < 3; ++k)
                        image[k] = static_cast<std::int16_t>(image[k] + by[i][k] - by[c.site.index][k]);
                const auto same = std::ranges::find_if(
                    b.contacts, [&](const CellContact& d) { return d.site == c.site && d.image == image; });
                REQUIRE(same != b.contacts.end());
                CHECK(std::abs(same->area - c.area) <= same->area_error + c.area_error);
            }
        }
        CHECK(computed > 0);
    }
}

TEST_CASE("update: balls that move beside sides of a box that repeats along others") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> place(0, 8);
    const auto ball = [&] {
        return Sphere{Vec3(place(rng), place(rng), place(rng)), 0.5 + 0.25 * (place(rng) % 3)};
    };
    for (int round = 0; round < 6; ++round) {
        DiagramScene scene;
        scene.box = {Vec3::Zero(), Vec3::Constant(8)};
        scene.periodic = {round % 2 == 0, false, true};
        scene.objects = {Sphere{{4, 0, 4}, 1}, ball(), ball(), ball(), ball()};
        VoronoiDiagram diagram = voronoi_diagram(scene);
        for (const std::uint32_t number : {1u, 2u}) {
            CAPTURE(round);
            update(diagram, scene, number, ball());
            check_alike(diagram, voronoi_diagram(scene));
        }
    }
}

TEST_CASE("update: a ball so far away that all others are on a coarser grid") {
    // What was rounded anew had other faces than what was not, and cells of pairs did not agree.
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(1)};
    scene.periodic = {true, true, true};
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(0, 1);
    for (int i = 0; i < 60; ++i)
        scene.objects.emplace_back(Sphere{Vec3(place(rng), place(rng), place(rng)), 0.01});
    VoronoiDiagram diagram = voronoi_diagram(scene);
    const Vec3 center = std::get<Sphere>(scene.objects[0]).center;
    for (const double edges : {1000.0, 0.0}) {
        update(diagram, scene, 0, Sphere{center + Vec3(edges, 0, 0), 0.01});
        CHECK(contacts(diagram).faults == std::vector<std::string>());
        const VoronoiDiagram anew = voronoi_diagram(scene);
        for (std::size_t i = 0; i < anew.cells.size(); ++i)
            CHECK(std::abs(diagram.cells[i].volume - anew.cells[i].volume) <=
                  diagram.cells[i].volume_error + anew.cells[i].volume_error);
    }
}

TEST_CASE("update: what is refused leaves the scene and its diagram as they were") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(1)};
    scene.periodic = {true, true, true};
    scene.objects = {Sphere{{0.25, 0.25, 0.25}, 0.1}, Sphere{{0.75, 0.75, 0.5}, 0.1}};
    const std::vector<Object> objects = scene.objects;
    VoronoiDiagram diagram = voronoi_diagram(scene);
    const double volume = diagram.cells[0].volume;
    CHECK_THROWS_AS(update(diagram, scene, 1, Plane{}), InputError);
    CHECK_THROWS_AS(update(diagram, scene, 1, Sphere{{0, 0, 0}, -1}), InputError);
    CHECK(scene.objects == objects);
    CHECK(diagram.cells[0].volume == volume);
}

TEST_CASE("voronoi_diagram: boxes too small for their balls, and balls too far away, are named") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(4)};
    scene.periodic = {true, true, true};
    scene.objects = {Sphere{{1, 1, 1}, 1}, Sphere{{3, 3, 4e9}, 1}};
    CHECK_THROWS_WITH_AS(voronoi_diagram(scene), doctest::Contains("objects[1].sphere.center"), InputError);
    scene.objects[1] = Sphere{{3, 3, 3}, 4e9};
    CHECK_THROWS_WITH_AS(voronoi_diagram(scene), doctest::Contains("box"), InputError);
}

}  // namespace vcell::repeating_boxes_test
