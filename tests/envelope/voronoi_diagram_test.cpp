// Whole diagrams against brute force: who is nearest to sampled points, what lattices are known to have, and
// the cells of all objects computed among all others.
#include "../../envelope/voronoi_diagram.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../primitives/reference.hpp"
#include "../test_support.hpp"
#include "diagram_checks.hpp"
#include "molecule.hpp"

namespace vcell::voronoi_diagram_test {
namespace {

using State = DiagramCell::State;

DiagramScene random_balls(std::mt19937_64& rng, std::size_t n, double least, double most) {
    std::uniform_real_distribution<double> place(0, 1), radius(least, most);
    DiagramScene scene;
    scene.box = {Vec3::Constant(-0.1), Vec3::Constant(1.1)};
    for (std::size_t i = 0; i < n; ++i)
        scene.objects.push_back(Sphere{{place(rng), place(rng), place(rng)}, radius(rng)});
    return scene;
}

const DiagramCell& cell_of(const VoronoiDiagram& diagram, std::size_t i) { return diagram.cells[i]; }

bool are_same(const VoronoiDiagram& a, const VoronoiDiagram& b) {
    const auto same = [](const DiagramCell& p, const DiagramCell& q) {
        bool equal = p.state == q.state && p.volume == q.volume && p.area == q.area &&
                     p.candidates == q.candidates && p.contacts.size() == q.contacts.size();
        for (std::size_t i = 0; equal && i < p.contacts.size(); ++i)
            equal = p.contacts[i].site == q.contacts[i].site && p.contacts[i].image == q.contacts[i].image &&
                    p.contacts[i].area == q.contacts[i].area;
        return equal;
    };
    return std::ranges::equal(a.cells, b.cells, same);
}

}  // namespace

TEST_CASE("voronoi_diagram: balls of any radii fill the box, both cells of a pair have the same faces") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round)
        for (const auto& [least, most] : {std::pair(0.0, 0.0), std::pair(0.01, 0.05), std::pair(0.0, 0.25)}) {
            CAPTURE(round);
            CAPTURE(most);
            const DiagramScene scene = random_balls(rng, 60, least, most);
            const VoronoiDiagram diagram = voronoi_diagram(scene);
            check_whole(scene, diagram);
            check_sampled(scene, diagram, rng);
        }
}

// Cells that are kept are computed among balls that are found by another bound.
TEST_CASE("voronoi_diagram: measures alone are those of cells that are kept") {
    std::mt19937_64 rng(test_seed() + 9);
    DiagramScene few = random_balls(rng, 7, 0.01, 0.3), sparse = random_balls(rng, 60, 0.001, 0.002),
                 repeated = random_balls(rng, 60, 0.01, 0.05);
    // Large balls beside many small ones, whose faces with those reach beyond a hemisphere.
    DiagramScene mixed = random_balls(rng, 80, 0.001, 0.01);
    for (const double x : {-0.05, 0.5, 1.05}) mixed.objects.push_back(Sphere{{x, 0.5, 1 - x}, 0.12});
    repeated.periodic = {true, true, true};
    for (const DiagramScene& scene : {few, sparse, repeated, mixed}) {
        const VoronoiDiagram alone = voronoi_diagram(scene);
        DiagramOptions options;
        options.visit = [](std::uint32_t, const Cell&) {};
        const VoronoiDiagram kept = voronoi_diagram(scene, options);
        check_whole(scene, alone);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            CAPTURE(i);
            const DiagramCell &a = alone.cells[i], &b = kept.cells[i];
            REQUIRE(a.state == b.state);
            if (a.state != State::Computed) continue;
            CHECK(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error);
            CHECK(std::abs(a.area - b.area) <= a.area_error + b.area_error);
            CHECK(a.max_clearance == doctest::Approx(b.max_clearance).epsilon(1e-9));
            CHECK(a.min_clearance == doctest::Approx(b.min_clearance).epsilon(1e-9));
            CHECK(a.touches_box == b.touches_box);
            REQUIRE(a.contacts.size() == b.contacts.size());
            for (std::size_t k = 0; k < a.contacts.size(); ++k) {
                CHECK(a.contacts[k].site == b.contacts[k].site);
                CHECK(a.contacts[k].image == b.contacts[k].image);
                CHECK(a.contacts[k].faces == b.contacts[k].faces);
            }
        }
    }
}

TEST_CASE("voronoi_diagram: a cell is that among all other objects") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = random_balls(rng, 200, 0.0, 0.04);
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    std::size_t fewer = 0;
    for (std::uint32_t i = 0; i < scene.objects.size(); i += 7) {
        if (cell_of(diagram, i).state != State::Computed) continue;
        CAPTURE(i);
        Scene all;
        all.base = scene.objects[i];
        all.base_object = i;
        all.objects = scene.objects;
        all.box = scene.box;
        const Cell cell = voronoi_cell(all);
        const DiagramCell& found = cell_of(diagram, i);
        CHECK(std::abs(found.volume - cell.measures.volume) <=
              found.volume_error + cell.measures.volume_error);
        std::size_t neighbors = 0;
        for (const CellContact& c : found.contacts) neighbors += c.site.is_object();
        CHECK(neighbors == cell.neighbors.size());
        fewer += found.candidates < scene.objects.size() - 1;
    }
    CHECK(fewer > 20);
}

TEST_CASE("voronoi_diagram: crambin's atoms fill their box") {
    DiagramScene scene;
    const std::vector<Sphere> balls = molecule("1CRN.xyzr");
    REQUIRE(balls.size() == 327);
    scene.objects.assign(balls.begin(), balls.end());
    scene.box = {balls[0].center, balls[0].center};
    for (const Sphere& b : balls) {
        scene.box.min = scene.box.min.cwiseMin(b.center - Vec3::Constant(5));
        scene.box.max = scene.box.max.cwiseMax(b.center + Vec3::Constant(5));
    }
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    check_whole(scene, diagram);

    SUBCASE("the result is the same for any number of threads") {
        DiagramOptions options;
        options.threads = 3;
        std::uint32_t visited = 0;
        options.visit = [&](std::uint32_t object, const Cell& cell) {
            CHECK(object == visited++);
            const DiagramCell& measured = cell_of(diagram, object);
            CHECK(std::abs(cell.measures.volume - measured.volume) <=
                  cell.measures.volume_error + measured.volume_error);
        };
        const VoronoiDiagram kept = voronoi_diagram(scene, options);
        CHECK(visited == 327);
        options.threads = 1;
        visited = 0;
        CHECK(are_same(kept, voronoi_diagram(scene, options)));
        DiagramOptions alone;
        alone.threads = 3;
        CHECK(are_same(diagram, voronoi_diagram(scene, alone)));
    }
    SUBCASE("the order of the objects does not matter") {
        DiagramScene reversed = scene;
        std::ranges::reverse(reversed.objects);
        const VoronoiDiagram other = voronoi_diagram(reversed);
        for (std::size_t i = 0; i < 327; ++i) {
            const DiagramCell &a = cell_of(diagram, i), &b = cell_of(other, 326 - i);
            CAPTURE(i);
            CHECK(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error);
            CHECK(a.contacts.size() == b.contacts.size());
        }
    }
    SUBCASE("a damaged contact is seen") {
        VoronoiDiagram damaged = diagram;
        CHECK(contacts(damaged).faults.empty());
        auto& at = damaged.cells[100].contacts;
        const auto c = std::ranges::find_if(at, [](const CellContact& x) { return x.site.is_object(); });
        REQUIRE(c != at.end());
        SUBCASE("its area") { c->area *= 1 + 1e-6; }
        SUBCASE("its absence") { at.erase(c); }
        CHECK(contacts(damaged).faults.size() == 1);
    }
}

TEST_CASE("voronoi_diagram: lattices have the faces they are known for, where the box repeats") {
    struct Lattice {
        std::vector<Vec3> places;
        std::size_t faces;
    };
    const std::array lattices{Lattice{{{0, 0, 0}}, 6},                                     // cubic
                              Lattice{{{0, 0, 0}, {1, 1, 1}}, 14},                         // body-centred
                              Lattice{{{0, 0, 0}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}}, 12}};  // face-centred
    for (const Lattice& lattice : lattices)
        for (const int cells : {1, 2}) {
            CAPTURE(lattice.faces);
            CAPTURE(cells);
            DiagramScene scene;
            scene.box = {Vec3::Zero(), Vec3::Constant(2 * cells)};
            scene.periodic = {true, true, true};
            for (int a = 0; a < cells; ++a)
                for (int b = 0; b < cells; ++b)
                    for (int c = 0; c < cells; ++c)
                        for (const Vec3& p : lattice.places)
                            scene.objects.push_back(Sphere{p + 2.0 * Vec3(a, b, c), 0.25});
            const VoronoiDiagram diagram = voronoi_diagram(scene);
            CHECK(diagram.moved == 0);
            check_whole(scene, diagram);
            for (const DiagramCell& cell : diagram.cells) {
                CHECK(cell.contacts.size() == lattice.faces);
                CHECK_FALSE(cell.touches_box);
            }
        }
}

TEST_CASE(
    "voronoi_diagram: boxes that repeat are filled, along some axes, leaning, and smaller than their cells") {
    std::mt19937_64 rng(test_seed());
    for (const std::array<bool, 3> periodic :
         {std::array{true, true, true}, std::array{true, false, false}, std::array{false, true, true}})
        for (const bool leans : {false, true}) {
            if (leans && !periodic[0]) continue;
            if (leans && !periodic[1]) continue;
            for (const std::size_t n : {1, 3, 40}) {
                CAPTURE(n);
                CAPTURE(leans);
                DiagramScene scene = random_balls(rng, n, 0.0, n > 3 ? 0.1 : 0.3);
                scene.box = {Vec3::Zero(), {1, 1.25, 1.5}};
                scene.periodic = periodic;
                if (leans) scene.tilt = {0.4, -0.3, 0.55};
                const VoronoiDiagram diagram = voronoi_diagram(scene);
                check_whole(scene, diagram);
                check_sampled(scene, diagram, rng);
            }
        }
}

TEST_CASE("voronoi_diagram: moved by an edge of a box that repeats nothing changes but images") {
    std::mt19937_64 rng(test_seed());
    DiagramScene scene = random_balls(rng, 20, 0.0, 0.1);
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.periodic = {true, true, true};
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    DiagramScene moved = scene;
    for (std::size_t i = 0; i < moved.objects.size(); i += 3)
        std::get<Sphere>(moved.objects[i]).center.x() += 1;
    const VoronoiDiagram other = voronoi_diagram(moved);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const DiagramCell &a = cell_of(diagram, i), &b = cell_of(other, i);
        CAPTURE(i);
        // The grid is coarser for larger coordinates.
        CHECK(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error + 1e-11);
        CHECK(a.contacts.size() == b.contacts.size());
    }
}

TEST_CASE("voronoi_diagram: in a box that repeats a cell is that among 27 copies of the box") {
    std::mt19937_64 rng(test_seed());
    DiagramScene scene = random_balls(rng, 8, 0.0, 0.15);
    scene.box = {Vec3::Zero(), {1, 1.25, 1.5}};
    scene.periodic = {true, true, true};
    // On the grid that the box repeats on, so that copies are where images are.
    for (Object& o : scene.objects)
        for (double& x : std::get<Sphere>(o).center) x = std::ldexp(std::round(std::ldexp(x, 20)), -20);
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    DiagramScene copies;
    copies.box = {{-1, -1.25, -1.5}, {2, 2.5, 3}};
    copies.objects = scene.objects;
    for (int a = -1; a <= 1; ++a)
        for (int b = -1; b <= 1; ++b)
            for (int c = -1; c <= 1; ++c)
                if (a != 0 || b != 0 || c != 0)
                    for (Object o : scene.objects) {
                        std::get<Sphere>(o).center += Vec3(a, 1.25 * b, 1.5 * c);
                        copies.objects.push_back(o);
                    }
    const VoronoiDiagram among = voronoi_diagram(copies);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const DiagramCell &a = cell_of(diagram, i), &b = cell_of(among, i);
        CAPTURE(i);
        REQUIRE(a.state == b.state);
        if (a.state != State::Computed) continue;
        REQUIRE_FALSE(b.touches_box);
        CHECK(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error);
        CHECK(std::abs(a.area - b.area) <= a.area_error + b.area_error);
        CHECK(a.contacts.size() == b.contacts.size());
    }
}

TEST_CASE("voronoi_diagram: turned and moved lattices have the same cells, with vertices of many balls") {
    // Of integers, all of a norm that is one: turns of a lattice that stay exact.
    const std::array<Eigen::Matrix3d, 3> turns{Eigen::Matrix3d(9 * Eigen::Matrix3d::Identity()),
                                               Eigen::Matrix3d{{1, -8, 4}, {4, 4, 7}, {-8, 1, 4}},
                                               Eigen::Matrix3d{{7, 4, 4}, {-4, 8, -1}, {-4, -1, 8}}};
    for (const auto& [faces, vertices, most] :
         {std::tuple(12, 14, 6), std::tuple(14, 24, 4), std::tuple(6, 8, 8)})
        for (const Eigen::Matrix3d& turn : turns) {
            CAPTURE(faces);
            DiagramScene scene;
            scene.box = {Vec3::Constant(-60), Vec3::Constant(60)};
            std::size_t middle = 0;
            const int layers = rounds() > 1 ? 3 : 2;
            for (int a = -layers; a <= layers; ++a)
                for (int b = -layers; b <= layers; ++b)
                    for (int c = -layers; c <= layers; ++c) {
                        const bool is_even = (a + b + c) % 2 == 0,
                                   is_alike = (a - b) % 2 == 0 && (b - c) % 2 == 0;
                        if (faces == 12 ? !is_even : faces == 14 && !is_alike) continue;
                        if (a == 0 && b == 0 && c == 0) middle = scene.objects.size();
                        scene.objects.push_back(Sphere{turn * Vec3(a, b, c) + Vec3(1, -2, 0.5), 1});
                    }
            DiagramOptions options;
            std::size_t visited = 0;
            options.visit = [&](std::uint32_t object, const Cell& cell) {
                if (object != middle) return;
                ++visited;
                CHECK(cell.faces.size() == static_cast<std::size_t>(faces));
                CHECK(cell.vertices.size() == static_cast<std::size_t>(vertices));
                std::size_t sites = 0;
                for (const CellVertex& v : cell.vertices) sites = std::max(sites, v.sites.size());
                CHECK(sites + 1 == static_cast<std::size_t>(most));
            };
            const VoronoiDiagram diagram = voronoi_diagram(scene, options);
            CHECK(visited == 1);
            const double volume = 729.0 * (faces == 12 ? 2 : faces == 14 ? 4 : 1);
            const DiagramCell& cell = cell_of(diagram, middle);
            CHECK(std::abs(cell.volume - volume) <= cell.volume_error);
            CHECK(cell.assumed == 0);
        }
}

TEST_CASE("voronoi_diagram: points in a box that repeats have the volumes and neighbours that Voro++ finds") {
    const std::string program = VCELL_VOROPP;
    if (program.empty()) {
        MESSAGE("skipped: voro++ is not installed");
        return;
    }
    std::mt19937_64 rng(test_seed());
    DiagramScene scene = random_balls(rng, 200, 0.0, 0.0);
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.periodic = {true, true, true};
    std::string folder = (std::filesystem::temp_directory_path() / "vcell_voropp.XXXXXX").string();
    REQUIRE(mkdtemp(folder.data()) != nullptr);
    const std::string path = folder + "/points";
    {
        std::ofstream out(path);
        out.precision(17);
        for (std::size_t i = 0; i < scene.objects.size(); ++i)
            out << i << ' ' << std::get<Sphere>(scene.objects[i]).center.transpose() << '\n';
    }
    REQUIRE(std::system((program + " -p -c '%i %v %s' 0 1 0 1 0 1 " + path).c_str()) == 0);
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    check_whole(scene, diagram);
    std::ifstream in(path + ".vol");
    std::size_t i, faces, compared = 0;
    for (double volume; in >> i >> volume >> faces; ++compared) {
        const DiagramCell& cell = cell_of(diagram, i);
        CAPTURE(i);
        // It prints six digits.
        CHECK(cell.volume == doctest::Approx(volume).epsilon(1e-5));
        std::size_t own = 0;
        for (const CellContact& c : cell.contacts) own += c.faces;
        CHECK(own == faces);
    }
    CHECK(compared == 200);
    std::filesystem::remove_all(folder);
}

TEST_CASE("voronoi_diagram: balls in balls and equal balls have no cell") {
    std::mt19937_64 rng(test_seed());
    DiagramScene scene = random_balls(rng, 30, 0.05, 0.1);
    const Sphere large = std::get<Sphere>(scene.objects[4]);
    scene.objects.push_back(Sphere{large.center, 0.5 * large.radius});  // 30, in it
    scene.objects.push_back(large);                                     // 31, equal
    const double half = 0.5 * large.radius;                             // 32, touching it from within
    scene.objects.push_back(Sphere{large.center + Vec3(half, 0, 0), half});
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    check_whole(scene, diagram);
    for (const std::size_t i : {30, 31}) {
        const DiagramCell& cell = cell_of(diagram, i);
        CHECK(cell.state == State::Empty);
        // The object that is named does hold it.
        CAPTURE(cell.reason);
        const std::size_t number = std::stoul(cell.reason.substr(cell.reason.find("object ") + 7));
        const auto &holder = std::get<Sphere>(scene.objects[number]),
                   &held = std::get<Sphere>(scene.objects[i]);
        CHECK((holder.center - held.center).norm() <= (holder.radius - held.radius) * (1 + 1e-15) + 1e-15);
    }
}

TEST_CASE("voronoi_diagram: of equal points in the origin the first one has a cell") {
    DiagramScene scene;
    scene.box = {Vec3::Constant(-1), Vec3::Constant(1)};
    scene.objects = {Sphere{{0, 0, 0}, 0}, Sphere{{0, 0, 0}, 0}, Sphere{{0.5, 0, 0}, 0}};
    for (const bool is_periodic : {false, true}) {
        scene.periodic = {is_periodic, is_periodic, is_periodic};
        const VoronoiDiagram diagram = voronoi_diagram(scene);
        check_whole(scene, diagram);
        CHECK(diagram.cells[0].state == State::Computed);
        CHECK(diagram.cells[1].state == State::Empty);
        CHECK(diagram.cells[1].reason == "equals object 0");
    }
}

TEST_CASE("voronoi_diagram: what lies in a tube or a plane, and equal tubes and planes, have no cell") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(4)};
    const std::vector<std::pair<Object, std::string>> all{
        {Cylinder{{0, 1, 1}, {1, 0, 0}, 0.5}, ""},
        {Cylinder{{4, 1, 1}, {-2, 0, 0}, 0.5}, "equals object 0"},
        {Cylinder{{1, 1, 1.25}, {3, 0, 0}, 0.25}, "lies in object 0"},  // touches it from within
        {Sphere{{2, 1.25, 1}, 0.25}, "lies in object 0"},
        {Sphere{{2, 1, 1}, 0.5}, "lies in object 0"},
        {Plane{{0, 0, 3}, {0, 0, 1}}, ""},
        {Plane{{1, 1, 3}, {0, 0, -2}}, "equals object 5"},
        {Sphere{{1, 2, 3}, 0}, "lies in object 5"},
        {Cylinder{{0, 3, 3}, {1, 1, 0}, 0}, "lies in object 5"},
        {Sphere{{2, 3, 1.5}, 0.5}, ""},
        {Sphere{{1, 3, 1.5}, 0.25}, ""}};
    for (const auto& [object, reason] : all) scene.objects.push_back(object);
    DiagramOptions options;
    options.bodies = true;
    const VoronoiDiagram diagram = voronoi_diagram(scene, options);
    for (std::size_t i = 0; i < all.size(); ++i) {
        CAPTURE(i);
        CHECK(diagram.cells[i].reason == all[i].second);
        CHECK(diagram.cells[i].state == (all[i].second.empty() ? State::Computed : State::Empty));
    }
    check_whole(scene, diagram);
    const FilledVolume bodies = body_volume(scene, diagram);
    const double expected = std::numbers::pi * (4 * 0.25 + 4.0 / 3 * (0.125 + 0.015625));
    CHECK(std::abs(bodies.volume - expected) <= bodies.error + 1e-13);
    // Moved out of the others an object has a cell again.
    VoronoiDiagram moved = diagram;
    update(moved, scene, 2, Cylinder{{1, 1, 2.5}, {3, 0, 0}, 0.25}, options);
    CHECK(moved.cells[2].state == State::Computed);
    check_whole(scene, moved);
}

TEST_CASE("voronoi_diagram: planes, tubes, lines and balls fill a box together") {
    std::mt19937_64 rng(test_seed());
    DiagramScene scene = random_balls(rng, 12, 0.0, 0.05);
    for (Object& o : scene.objects) {
        Vec3& c = std::get<Sphere>(o).center;
        c.z() = 0.25 + 0.5 * c.z();
        c.x() = c.x() < 0.5 ? 0.6 * c.x() : 0.4 + 0.6 * c.x();
    }
    scene.objects.push_back(Cylinder{{0.4, 0, 0.5}, {0, 1, 0}, 0.03});
    scene.objects.push_back(Plane{{0, 0, 0}, {0, 0, 1}});
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    check_whole(scene, diagram);
    check_sampled(scene, diagram, rng);
}

TEST_CASE(
    "update: an object that moves changes the cells near it, and the diagram becomes that of the new scene") {
    std::mt19937_64 rng(test_seed());
    DiagramScene scene = random_balls(rng, 150, 0.0, 0.04);
    VoronoiDiagram diagram = voronoi_diagram(scene);
    std::size_t visited = 0;
    DiagramOptions options;
    options.visit = [&](std::uint32_t, const Cell&) { ++visited; };
    for (const std::uint32_t number : {3u, 77u, 140u}) {
        Sphere ball = std::get<Sphere>(scene.objects[number]);
        ball.center += Vec3(0.05, -0.03, 0.02);
        ball.center = ball.center.cwiseMax(0.0).cwiseMin(1.0);
        update(diagram, scene, number, ball, options);
        CHECK(std::get<Sphere>(scene.objects[number]) == ball);
        check_whole(scene, diagram);
        check_alike(diagram, voronoi_diagram(scene));
    }
    CHECK(visited < 3 * 100);
    CHECK_THROWS_AS(update(diagram, scene, 150, Sphere{}), InputError);
}

TEST_CASE(
    "contacts: a ball beyond a side of the box, the mirror image of one inside, has no cell to lack a face") {
    DiagramScene scene;
    scene.objects = {Sphere{{-1, 0, 0}, 0.25}, Sphere{{1, 0, 0}, 0.25}, Sphere{{-1, 1, 0.5}, 0.25}};
    scene.box = {Vec3::Constant(-2), {0, 2, 2}};
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    CHECK(std::abs(diagram.cells[1].volume) <= diagram.cells[1].volume_error);
    const ContactTable table = contacts(diagram);
    CHECK(table.faults == std::vector<std::string>());
    CHECK(std::ranges::count_if(table.contacts, [](const Contact& c) {
              return c.first == 0 && c.second == Site::object(1) && c.area > 1;
          }) == 1);
    // A face that is lost is told yet.
    VoronoiDiagram lacking = diagram;
    std::erase_if(lacking.cells[2].contacts, [](const CellContact& c) { return c.site == Site::object(0); });
    CHECK(contacts(lacking).faults.size() == 1);
}

TEST_CASE("voronoi_diagram: what is no scene is named") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    CHECK_THROWS_AS(voronoi_diagram(scene), InputError);
    scene.objects.push_back(Sphere{{0.5, 0.5, 0.5}, 0.1});
    CHECK(filled_volume(scene, voronoi_diagram(scene)).fills());
    scene.tilt = {0.1, 0, 0};
    CHECK_THROWS_AS(voronoi_diagram(scene), InputError);
    scene.periodic = {true, true, true};
    CHECK(filled_volume(scene, voronoi_diagram(scene)).fills());
    scene.objects.push_back(Plane{});
    CHECK_THROWS_AS(voronoi_diagram(scene), InputError);
    scene.objects[1] = Sphere{{0.5, 0.5, std::nan("")}, 0.1};
    CHECK_THROWS_AS(voronoi_diagram(scene), InputError);
}

TEST_CASE("voronoi_diagram: progress ends at one, and what it throws ends the work") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = random_balls(rng, 300, 0.0, 0.02);
    DiagramOptions options;
    double last = 0;
    options.progress = [&](double fraction) {
        CHECK(fraction > last);
        last = fraction;
    };
    voronoi_diagram(scene, options);
    CHECK(last == 1);
    struct Cancelled {};
    options.progress = [](double) { throw Cancelled(); };
    CHECK_THROWS_AS(voronoi_diagram(scene, options), Cancelled);
}

}  // namespace vcell::voronoi_diagram_test
